"""Distances to solids match the nearest of very many points on their surface."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from recon.records import Box, Cone, Cylinder, Ellipsoid, Plane, Sphere, TruncatedCone

AXIS = np.array([0.0, 0.6, 0.8])
RNG = np.random.default_rng(5)
AXES = np.linalg.qr(RNG.normal(size=(3, 3)))[0]


def grid(count: int = 700) -> tuple[np.ndarray, np.ndarray]:
    """Make shares (0 to 1) and angles that together cover a surface."""
    share, turn = np.meshgrid(np.linspace(0, 1, count), np.linspace(0, 2 * np.pi, count))
    return share.ravel(), turn.ravel()


def surface_of_revolution(point, axis, height, low, high):
    share, turn = grid()
    across = np.linalg.svd(axis[None])[2][1:]
    rho = low + share * (high - low)
    circle = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
    return point + (share * height)[:, None] * axis + rho[:, None] * circle


def ball(radii, axes):
    share, turn = grid()
    polar = np.pi * share
    unit = np.column_stack(
        [np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)]
    )
    return unit * radii @ axes


def faces(sizes, axes):
    u, v = (
        a.ravel() for a in np.meshgrid(np.linspace(-0.5, 0.5, 200), np.linspace(-0.5, 0.5, 200))
    )
    sides = [
        np.roll(np.column_stack([np.full_like(u, s), u, v]), k, axis=1)
        for k in range(3)
        for s in (-0.5, 0.5)
    ]
    return np.concatenate(sides) * sizes @ axes


POINT = np.array([1.0, -2.0, 0.5])
SURFACES = [
    (Sphere(centre=POINT, radius=1.3), POINT + ball(np.full(3, 1.3), AXES)),
    (
        Ellipsoid(centre=POINT, radii=np.array([2.0, 1.2, 0.4]), axes=AXES),
        POINT + ball(np.array([2.0, 1.2, 0.4]), AXES),
    ),
    (
        Cylinder(point=POINT, axis=AXIS, radius=0.7, height=2.0),
        surface_of_revolution(POINT, AXIS, 2.0, 0.7, 0.7),
    ),
    (
        Cone(apex=POINT, axis=AXIS, half_angle_rad=np.arctan(0.5), height=2.0),
        surface_of_revolution(POINT, AXIS, 2.0, 0.0, 1.0),
    ),
    (
        TruncatedCone(point=POINT, axis=AXIS, radius_bottom=1.2, radius_top=0.4, height=1.5),
        surface_of_revolution(POINT, AXIS, 1.5, 1.2, 0.4),
    ),
    (
        Box(centre=POINT, axes=AXES, sizes=np.array([1.0, 2.0, 0.5])),
        POINT + faces(np.array([1.0, 2.0, 0.5]), AXES),
    ),
]


@pytest.mark.parametrize(("solid", "surface"), SURFACES, ids=lambda item: getattr(item, "kind", ""))
def test_distance_is_that_to_the_nearest_surface_point(solid, surface):
    points = POINT + RNG.uniform(-3.0, 3.0, (400, 3))
    brute = cKDTree(surface).query(points)[0]
    np.testing.assert_allclose(solid.distances(points), brute, atol=5e-3)
    # A surface point lies on the solid; a displaced one does not.
    assert solid.distances(surface[::997]).max() < 1e-8
    assert solid.distances(points).min() > 0


def test_cylinder_and_cone_are_open():
    cylinder = Cylinder(point=np.zeros(3), axis=np.array([0.0, 1.0, 0.0]), radius=2.0, height=4.0)
    lid_middle = np.array([[0.0, 4.0, 0.0]])
    assert cylinder.distances(lid_middle) == pytest.approx(2.0)


def test_plane_is_unbounded():
    plane = Plane(point=np.zeros(3), normal=AXIS)
    far = 1e6 * np.array([[1.0, 0.0, 0.0]]) + 3.0 * AXIS
    assert plane.distances(far) == pytest.approx(3.0)


def test_centre_of_an_ellipsoid_is_one_short_half_axis_away():
    solid = Ellipsoid(centre=POINT, radii=np.array([3.0, 2.0, 1.0]), axes=AXES)
    assert solid.distances(POINT[None]) == pytest.approx(1.0, abs=1e-6)
