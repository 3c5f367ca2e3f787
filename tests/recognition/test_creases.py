"""Clumps come apart into convex pieces that solids explain, and again where a piece is none."""

import numpy as np
import pytest

from recon.recognition import separation
from recon.recognition.cells import gather
from recon.recognition.fitting.surface_points import surface
from recon.recognition.naming.naming import unknown
from recon.recognition.separation import cut_at_creases
from recon.records import Box, PointCloud


@pytest.fixture
def row():
    """Cells of three boxes in a row, each one unit wide."""
    rng = np.random.default_rng(0)
    sizes = ([0.9, 1.0, 0.5], [0.9, 0.4, 1.2], [0.9, 0.8, 0.7])
    boxes = [
        Box(centre=np.array([x + 0.5, size[1] / 2.0, 0.0]), axes=np.eye(3), sizes=np.array(size))
        for x, size in enumerate(sizes)
    ]
    points = surface(boxes, 9000, rng).points
    return gather(PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8)), 0.08)


def first_apart(cells, *_):
    """Two pieces: the box with the lowest x, and the others together."""
    number = np.floor(cells.means[:, 0]).astype(np.int32)
    return np.minimum(number - number.min(), 1)


def pieces_of(cells):
    def name(rows):
        return unknown(cells.select(rows), 0.0, "")

    rows = np.arange(len(cells))
    whole = (name(rows), rows)
    found = cut_at_creases(whole, cells, 12, relief_of=cells.select, eyes=None, name=name)
    return sorted(np.unique(np.floor(cells.means[own, 0])).tolist() for _, own in found)


def test_a_piece_that_is_no_solid_is_split_again(row, monkeypatch):
    monkeypatch.setattr(separation, "fewest_pieces", first_apart)
    assert pieces_of(row) == [[0.0], [1.0], [2.0]]


@pytest.mark.parametrize(
    ("shares", "is_cut"),
    [((0.9, 0.9, 0.9), True), ((0.75, 0.75, 0.75), True), ((0.9, 0.9, 0.65), False)],
    ids=["on solids", "mostly on solids", "a third on none"],
)
def test_a_clump_is_cut_where_solids_explain_most_of_it(shares, is_cut, row, monkeypatch):
    def explained(cells):
        low, high = np.floor(cells.means[[0, -1], 0]).astype(int)
        return shares[low] if low == high else 0.3

    monkeypatch.setattr(separation, "fewest_pieces", first_apart)
    monkeypatch.setattr(separation, "_explained", explained)
    assert len(pieces_of(row)) == (3 if is_cut else 1)
