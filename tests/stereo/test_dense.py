"""Planes over segments: exact on a plane, cut at edges, nothing where nothing supports it."""

import numpy as np
import pytest
from test_triangulation import matches_of

from recon.errors import InputError
from recon.records import Matches
from recon.settings.stereo import DenseSettings
from recon.stereo.dense import densify, is_spike

SHAPE = (60, 80)


def grid_matches(disparity, spacing=3, noise=0.0, seed=0):
    v, u = np.mgrid[1 : SHAPE[0] : spacing, 1 : SHAPE[1] : spacing]
    points = np.column_stack([u.ravel(), v.ravel()])
    values = disparity[points[:, 1], points[:, 0]]
    return matches_of(points, values + np.random.default_rng(seed).normal(0, noise, len(points)))


def slanted():
    v, u = np.indices(SHAPE)
    return 5 + 0.05 * u + 0.02 * v


def test_a_slanted_plane_is_recovered():
    image = np.full((*SHAPE, 3), 100, np.uint8)
    found = densify(grid_matches(slanted(), noise=0.05), image, DenseSettings())
    assert np.isfinite(found).mean() > 0.95
    assert np.nanmedian(np.abs(found - slanted())) < 0.04
    assert np.nanmedian(np.abs(found - slanted() - 0.2)) > 0.1


@pytest.mark.parametrize("colours", [1, 3])
def test_disparity_jumps_where_the_picture_does(colours):
    image = np.full((*SHAPE, 3), 40, np.uint8)
    image[:, 40:] = 200
    truth = np.where(np.arange(SHAPE[1]) < 40, 3.0, 12.0) * np.ones((SHAPE[0], 1))
    found = densify(grid_matches(truth), image[..., 0] if colours == 1 else image, DenseSettings())
    assert np.nanmax(np.abs(found - truth)) < 0.5
    assert np.isfinite(found[:, 38:42]).mean() > 0.9


def test_segments_without_matches_are_unknown():
    everywhere = grid_matches(slanted())
    left_half = everywhere.select(everywhere.points_px[:, 0] < 30)
    found = densify(left_half, np.full(SHAPE, 90, np.uint8), DenseSettings())
    assert np.isfinite(found[:, :20]).mean() > 0.9
    assert np.isnan(found[:, 50:]).all()


def test_spikes_are_found_and_left_out():
    truth = slanted()
    truth[31, 31] += 20
    matches = grid_matches(truth)
    spikes = matches.points_px[is_spike(matches, DenseSettings())]
    assert spikes.tolist() == [[31, 31]]
    found = densify(matches, np.full(SHAPE, 90, np.uint8), DenseSettings())
    assert np.nanmax(np.abs(found - slanted())) < 0.3


def test_no_matches_no_disparity():
    assert np.isnan(densify(Matches.none(), np.zeros(SHAPE, np.uint8), DenseSettings())).all()


def test_matches_outside_the_image_are_refused():
    with pytest.raises(InputError, match="outside the image of 10 x 10 pixels"):
        densify(grid_matches(slanted()), np.zeros((10, 10), np.uint8), DenseSettings())
