"""Large images are matched in strips: nothing is lost or duplicated where strips meet."""

from itertools import pairwise

import numpy as np
import pytest

from recon.mapping import sparse
from recon.mapping.sparse import match_sparse
from recon.settings import Settings, updated
from scenes import textured_pair, truth_at

SEARCH = {"matching": {"min_disparity": 0, "max_disparity": 16}}


@pytest.fixture(scope="module")
def pair():
    return textured_pair(shape=(700, 160), noise=1.0)


def solve(pair, **matching):
    settings = updated(Settings(), {"matching": SEARCH["matching"] | matching})
    return match_sparse(*pair[:2], settings)


def places(found):
    return {tuple(row) for row in found.matches.points_px.tolist()}


def test_strips_give_the_matches_of_the_whole_image(pair, monkeypatch):
    whole = solve(pair)
    monkeypatch.setattr(sparse, "_STRIP_BYTES", 1)
    assert len(list(sparse._strips((700, 160), (1.5, 3.0, 6.0)))) == 3
    strips = solve(pair)
    assert len(places(strips)) == len(strips.matches)
    assert len(places(whole) & places(strips)) > 0.93 * len(whole.matches)
    assert strips.num_features == pytest.approx(whole.num_features, rel=0.02)
    np.testing.assert_allclose(strips.image_noise, whole.image_noise, rtol=0.1)
    assert (np.diff(strips.matches.score) <= 0).all()
    error = np.abs(strips.matches.disparity_px - truth_at(pair[2], strips.matches))
    assert np.mean(error < 0.5) > 0.97
    rows = strips.matches.points_px[:, 1]
    beside_a_seam = [(np.abs(rows - seam) < 8).sum() for seam in (256, 512, 130, 400)]
    assert min(beside_a_seam) > 0.6 * max(beside_a_seam)


def test_the_most_confident_of_all_strips_are_kept(pair, monkeypatch):
    monkeypatch.setattr(sparse, "_STRIP_BYTES", 1)
    every, some = solve(pair), solve(pair, keep=50)
    np.testing.assert_array_equal(some.matches.score, every.matches.score[:50])


def test_small_images_are_one_strip():
    assert list(sparse._strips((500, 741, 3), (1.5, 3.0, 6.0))) == [(0, 500)]
    rows = list(sparse._strips((3000, 4000), (1.5, 3.0, 6.0)))
    assert len(rows) > 1
    assert rows[0][0] == 0
    assert rows[-1][1] == 3000
    assert all(end == first for (_, end), (first, _) in pairwise(rows))
