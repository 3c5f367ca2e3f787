"""Footprints: outlines of objects, in an order that rounding does not change."""

from dataclasses import replace

import numpy as np
import pytest

from recon.figures.footprints import least_rectangle, of_object, of_solid, rectangle
from recon.records import Box, Part


@pytest.mark.parametrize("angle_rad", [0.0, np.pi / 4.0, 1.0])
def test_outline_begins_at_the_same_corner_whatever_the_last_digits(angle_rad):
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    axes = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    rng = np.random.default_rng(0)
    corners = []
    for _ in range(50):
        centre = np.array([20.0, 1.0, -30.0]) + rng.uniform(-1e-13, 1e-13, 3)
        corners.append(of_solid(Box(centre=centre, axes=axes, sizes=np.array([4.0, 2.0, 9.0])))[0])
    np.testing.assert_allclose(corners, corners[:1] * 50, atol=1e-9)


def test_outline_begins_at_the_lowest_corner_and_keeps_its_sense():
    outline = rectangle(np.array([1.0, 2.0]), np.eye(2), np.array([2.0, 6.0]))
    np.testing.assert_allclose(outline[0], [0.0, -1.0])
    x, y = outline[:, 0], -outline[:, 1]
    assert (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2.0 == pytest.approx(12.0)


def test_outline_of_a_solid_in_another_is_that_of_the_outer_one(voxels, ball):
    outer = Box(centre=ball.centre, axes=np.eye(3), sizes=np.array([9.0, 2.0, 9.0]))
    inner = Box(centre=ball.centre, axes=np.eye(3), sizes=np.array([1.0, 2.0, 2.0]))
    parts = [
        Part(role="body", solid=solid, num_voxels=1, rms=0.0, hue_deg=None)
        for solid in (inner, outer)
    ]
    both, alone = (replace(ball, parts=tuple(parts[:number])) for number in (2, 1))
    np.testing.assert_array_equal(of_object(both, voxels), of_solid(outer))
    np.testing.assert_array_equal(of_object(alone, voxels), of_solid(inner))


def test_smallest_rectangle_around_points_on_a_line_has_no_width():
    along = np.array([0.6, 0.8])
    corners = least_rectangle(np.outer([1.0, 2.0, 4.5], along) + 7.0)
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    np.testing.assert_allclose(np.sort(sides), [0.0, 0.0, 3.5, 3.5], atol=1e-6)
