"""The compiled loops match the slow reference, in strips of any height."""

import numpy as np
import pytest
from reference import Pair, best_of

from recon.settings import FeatureSettings
from recon.stereo.features import detect
from recon.stereo.matching import ring
from recon.stereo.matching.aggregation import aggregate
from recon.stereo.matching.phase import _points, _responses
from recon.stereo.matching.search import C_COS, Search
from scenes import textured_pair

SEARCHES = [
    Search(-8, 9, 0, 1, False, C_COS),
    Search(-8, 9, 0, 2, False, C_COS),
    Search(-20, 33, 0, 2, False, C_COS),
    Search(-3, 17, 1, 1, False, C_COS),
    Search(2, 1, -1, 2, False, C_COS),
]


@pytest.fixture(scope="module")
def features():
    left, right, _ = textured_pair(shape=(46, 71), slope=(0.05, 0.02), middle=4.0, noise=6.0)
    settings = FeatureSettings(widths_px=(1.5, 3.0), share=0.2)
    return detect(left, settings), detect(right, settings)


@pytest.fixture(params=["one strip", "many strips"])
def strips(request, monkeypatch):
    if request.param == "many strips":
        monkeypatch.setattr(ring, "_RING_BYTES", 0)
        monkeypatch.setattr(ring, "_NARROWEST", 8)


def points_of(features, count=90):
    """Select some features, including the outermost ones."""
    rows = np.unique(np.linspace(0, len(features) - 1, count).astype(int))
    u, v = features.points_px.astype(np.int64).T
    rows = np.union1d(rows, [u.argmin(), u.argmax(), v.argmin(), v.argmax()])
    pixels = np.column_stack([u, v])[rows]
    return _points(pixels, features.orientation_rad[rows], len(features.grey))


@pytest.mark.parametrize("search", SEARCHES, ids=lambda s: "_".join(map(str, s[:4])))
def test_support_matches_the_reference(features, search, strips):
    points = points_of(features[0])
    found = aggregate(*(_responses(f) for f in features), points, search)
    slow = Pair(*features, search)
    compared = 0
    for i, (v, u) in enumerate(zip(points.v, points.u, strict=True)):
        support = slow.support(v, u)
        if not support.max() > 0:
            assert found.score[i] == -np.inf
            continue
        best, score, rival = best_of(support)
        assert found.score[i] == pytest.approx(score, rel=1e-4)
        if np.sum(support > score * (1 - 1e-4)) > 1:
            continue
        compared += 1
        assert found.shift[i] == search.first + best
        assert found.rival[i] == pytest.approx(rival, rel=1e-3, abs=1e-4)
        side = slow.side(v, u, best, points.orientation[i])
        assert found.side[i] == pytest.approx(side, rel=1e-3, abs=1e-4)
    assert compared > 50


def test_one_to_one_matching_keeps_the_best_partner(features, strips):
    search = Search(-8, 9, 0, 2, True, C_COS)
    points = points_of(features[0], 10_000)
    found = aggregate(*(_responses(f) for f in features), points, search)
    free = aggregate(*(_responses(f) for f in features), points, search._replace(is_unique=False))
    slow = Pair(*features, search)
    claims = np.full((len(features[0].grey), 200), -np.inf)
    for v, u in zip(points.v, points.u, strict=True):
        row = claims[v, u + search.first + 50 :][: search.num_shifts]
        np.maximum(row, slow.support(v, u), out=row)
    clearly = free.score - claims[points.v, points.u + free.shift + 50]
    matched = np.isfinite(free.score)
    assert np.isfinite(found.score[matched & (clearly > -1e-5)]).all()
    assert np.isinf(found.score[matched & (clearly < -1e-4)]).all()
    assert 10 < np.sum(matched & (clearly < -1e-4)) < 0.9 * matched.sum()
