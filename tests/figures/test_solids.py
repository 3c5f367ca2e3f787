"""Solids of objects are drawn only as far as the objects extend."""

import numpy as np
import pytest

from recon.figures.footprints import of_object, of_solid
from recon.figures.solids import drawn_solids, mesh
from recon.records import Cylinder, FoundObject, Part, Plane, Sphere, Voxels

CELL_SIZE = 0.1
MIDDLE = np.array([3.0, 1.0, -2.0])
WIDE, HIGH = 1.2, 0.6


def board(scale, tilt_deg):
    """Make the cells of a tilted board, and an object whose only part is its plane."""
    u, v = (np.arange(-size / 2, size / 2 + 1e-9, CELL_SIZE) for size in (WIDE, HIGH))
    c, s = np.cos(np.radians(tilt_deg)), np.sin(np.radians(tilt_deg))
    places = np.array([[a, b * s, b * c] for a in u for b in v])
    means, cell_size = scale * (MIDDLE + places), scale * CELL_SIZE
    index = np.floor(means / cell_size).astype(np.int64)
    voxels = Voxels(
        index=index, centres=(index + 0.5) * cell_size, means=means,
        counts=np.full(len(means), 9), cell_size=cell_size,
    )  # fmt: skip
    # The point of a plane may be anywhere on it.
    plane = Plane(point=scale * np.add(MIDDLE, [70.0, 0.0, 0.0]), normal=np.array([0.0, c, -s]))
    return voxels, found(plane, means)


def found(solid, means):
    low, high = means.min(axis=0), means.max(axis=0)
    return FoundObject(
        id=0, label="unknown", probability=1.0, centre=(low + high) / 2, size=high - low,
        num_voxels=len(means),
        parts=(Part(role="body", solid=solid, hue_deg=None, num_voxels=1, rms=0.0),),
    )  # fmt: skip


@pytest.mark.parametrize("scale", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("tilt_deg", [0.0, 30.0, 90.0])
def test_plane_is_drawn_as_far_as_its_cells_lie_on_it(scale, tilt_deg):
    voxels, one = board(scale, tilt_deg)
    (drawn,) = drawn_solids(voxels, one)
    solid = drawn.solid
    np.testing.assert_allclose(solid.centre, scale * MIDDLE, atol=0.02 * scale)
    wanted = scale * np.array([0.0, HIGH + CELL_SIZE, WIDE + CELL_SIZE])
    np.testing.assert_allclose(np.sort(solid.sizes), wanted, atol=0.05 * scale)
    points = np.asarray(mesh(solid).points)
    plane = one.parts[0].solid
    assert plane.distances(points).max() < 1e-6 * scale


def test_plane_without_cells_is_not_drawn():
    voxels, one = board(1.0, 0.0)
    assert list(drawn_solids(voxels.select(slice(0)), one)) == []


@pytest.mark.parametrize(("radius", "is_drawn"), [(0.6, True), (15.0, False)])
def test_solid_far_larger_than_its_object_is_not_drawn(radius, is_drawn):
    voxels, one = board(1.0, 90.0)
    wall = Cylinder(
        point=np.add(MIDDLE, [0.0, -0.3, -radius]), axis=np.array([0.0, 1.0, 0.0]), radius=radius,
        height=0.6,
    )  # fmt: skip
    one = found(wall, voxels.means)
    assert len(list(drawn_solids(voxels, one))) == is_drawn
    size = np.ptp(of_object(one, voxels), axis=0)
    assert size.max() == pytest.approx(2 * radius if is_drawn else WIDE, abs=0.05)


def test_ball_seen_from_one_side_is_drawn_whole():
    ball = Sphere(centre=MIDDLE, radius=1.0)
    angle = np.linspace(0.0, np.pi, 30)
    means = MIDDLE + np.column_stack([np.cos(angle), 0.0 * angle, np.sin(angle)])
    one = found(ball, means)
    index = np.floor(means / CELL_SIZE).astype(np.int64)
    voxels = Voxels(
        index=index, centres=(index + 0.5) * CELL_SIZE, means=means,
        counts=np.full(len(means), 9), cell_size=CELL_SIZE,
    )  # fmt: skip
    assert [drawn.solid for drawn in drawn_solids(voxels, one)] == [ball]
    np.testing.assert_array_equal(of_object(one, voxels), of_solid(ball))
