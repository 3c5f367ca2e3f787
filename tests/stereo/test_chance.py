"""Pairs that noise created are told from those of faint textures by all pairs of an image."""

import numpy as np
import pytest

from recon.stereo import chance
from recon.stereo.neighbours import Neighbours


@pytest.fixture
def rng():
    return np.random.default_rng(8)


def probability(log_odds, noise=0.5, trust=0.9, agreement=0.5, company=0.0):
    prior = 1 / (1 + np.exp(-np.asarray(log_odds, np.float64)))
    of_each = noise, trust, agreement, company
    full = [np.broadcast_to(x, len(log_odds)).astype(np.float32) for x in of_each]
    return chance.probability(prior, *full[:2], Neighbours(*full[2:]))


def test_same_score_is_improbable_only_where_noise_creates_pairs(rng):
    faint, created = rng.normal(1.5, 1.0, 3000), rng.normal(-1.45, 0.5, 3000)
    of_noise = slice(3000, None)
    together = probability(np.r_[faint, created])
    assert together[of_noise].mean() < 0.25 < 0.7 < together[:3000].mean()
    alone = probability(np.r_[faint, np.full(20, -0.8)])
    assert alone[of_noise].min() > 3 * together[of_noise].mean()


def test_order_of_evidence_is_kept(rng):
    log_odds = np.sort(np.r_[rng.normal(1.5, 1.0, 500), rng.normal(-1.45, 0.5, 500)])
    assert (np.diff(probability(log_odds)) >= -1e-9).all()


def test_edge_along_the_row_is_doubtful_if_noisy(rng):
    log_odds = rng.normal(2.0, 1.0, 1000)
    assert probability(log_odds, trust=0.0).mean() < 0.5 < probability(log_odds).mean()
    certain = probability(log_odds, noise=1e-4, trust=0.0)
    np.testing.assert_allclose(certain, probability(log_odds, noise=1e-4), atol=0.01)


def test_noisy_pairs_without_support_of_neighbours_are_improbable(rng):
    """Those of correlated noise have higher scores than those of white noise."""
    faint, created = rng.normal(1.5, 1.0, 3000), rng.normal(-1.0, 0.4, 500)
    log_odds = np.r_[faint, created]
    support = np.r_[rng.uniform(0.4, 1.0, 3000), rng.uniform(0.0, 0.3, 500)]
    created = slice(3000, None)
    informed = probability(log_odds, agreement=support)
    assert informed[created].mean() < 0.1 < 0.9 < informed[:3000].mean()
    assert (informed[created] >= 0.7).mean() < 0.01
    uninformed = probability(log_odds)
    assert uninformed[created].mean() > 2 * informed[created].mean()
    # Without noise, a pair alone may be as correct as any.
    certain = [probability(log_odds, noise=1e-4, agreement=x) for x in (0.0, 1.0)]
    np.testing.assert_allclose(*certain, atol=0.01)


def test_pair_that_looks_like_noise_is_correct_where_the_surface_agrees(rng):
    created = rng.normal(-1.45, 0.5, 3000)
    alone, with_others = (probability(created, company=x) for x in (0.0, 0.75))
    assert alone.mean() < 0.1 < 0.5 < with_others.mean() < 0.9
    few = probability(created, company=0.1).mean()
    assert alone.mean() < few < 2.5 * alone.mean()


def test_unknown_prior_stays_unknown():
    prior = np.array([0.8, np.nan])
    noise = np.array([np.inf, 0.1], np.float32)
    others = Neighbours(*np.ones((2, 2), np.float32))
    found = chance.probability(prior, noise, np.ones(2, np.float32), others)
    assert 0 < found[0] < 1
    assert np.isnan(found[1])
    none = np.ones(0, np.float32)
    assert len(chance.probability(prior[:0], none, none, Neighbours(none, none))) == 0
