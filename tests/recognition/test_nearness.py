"""What is near a point is found as by a tree, and what is coarser is as few as wanted."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from recon.recognition.adjacency import near_pairs
from recon.recognition.cells import coarser
from recon.recognition.fitting.normals import estimate_normals
from recon.recognition.segments.convexity import nearest_middle
from recon.records import Voxels

STRETCHES = [(1.0, 1.0, 1.0), (0.0, 1.0, 4.0), (9.0, 1e-3, 0.0)]


@pytest.mark.parametrize("stretch", STRETCHES)
def test_pairs_within_reach_are_those_of_a_tree(stretch):
    points = np.random.default_rng(0).normal(size=(400, 3)) * stretch
    pairs = near_pairs(points, 0.3)
    expected = cKDTree(points).query_pairs(0.3)
    assert {tuple(sorted(pair)) for pair in pairs.T.tolist()} == expected
    assert pairs.shape[1] == len(expected)


def test_nearest_middle_does_not_depend_on_the_label_at_first():
    rng = np.random.default_rng(1)
    places, middles = rng.normal(size=(500, 6)), rng.normal(size=(40, 6))
    expected = cKDTree(middles).query(places)[1]
    for label in (np.zeros(500, dtype=np.int64), rng.integers(40, size=500)):
        np.testing.assert_array_equal(nearest_middle(places, middles, label), expected)


def test_normals_of_a_noisy_ball_point_outwards():
    rng = np.random.default_rng(2)
    unit = rng.normal(size=(2000, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    normals = estimate_normals(5.0 * unit + rng.normal(0.0, 0.02, unit.shape))
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
    cosines = np.einsum("ij,ij->i", normals, unit)
    assert np.quantile(cosines, 0.05) > 0.95


@pytest.mark.parametrize("share", [0.02, 0.05, 0.1])
def test_coarser_cells_of_specks_are_about_as_few_as_wanted(share):
    rng = np.random.default_rng(3)
    index = np.argwhere(rng.random((30, 30, 30)) < share)
    coarse, first, cell = coarser(Voxels.occupied(index, 0.5), 100)
    assert 50 <= len(coarse) <= 200
    np.testing.assert_array_equal(cell[first], np.arange(len(coarse)))
