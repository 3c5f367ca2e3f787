"""Visuals as triangles: placed, oriented, textured and closed as the geometry file says."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.world.meshes import read_mesh
from recon.world.solids import (
    contains,
    cylinder_triangles,
    quarter_turns,
    sphere_triangles,
)
from recon.world.visuals import CylinderVisual, EllipsoidVisual, MeshVisual, SphereVisual

TILE = 16.0
CONE = CylinderVisual(radius_base=1, radius_top=7, height=4, translation=(20, 11, -5))
ALL = [
    sphere_triangles(SphereVisual(centre=(1, 2, 3), radius=4), TILE),
    sphere_triangles(EllipsoidVisual(centre=(1, 2, 3), radii=(4, 2, 3)), TILE),
    cylinder_triangles(CONE, TILE),
    cylinder_triangles(
        CylinderVisual(radius_base=2, radius_top=2, height=8, translation=(1, 8, 3)), TILE
    ),
]


def test_rotation_1_0_0_puts_the_translation_at_the_top():
    points = cylinder_triangles(CONE, TILE).corners.reshape(-1, 3)
    radius = np.hypot(points[:, 0] - 20, points[:, 2] + 5)
    assert np.ptp(points[:, 1]) == pytest.approx(4, abs=1e-12)
    np.testing.assert_allclose(radius[points[:, 1] > 11 - 1e-9], 1, atol=1e-12)
    np.testing.assert_allclose(radius[points[:, 1] < 7 + 1e-9], 7, atol=1e-12)


@pytest.mark.parametrize(
    ("rotation", "axis"),
    [
        ((0, 0, 0), (0, 0, 1)),
        ((1, 0, 0), (0, -1, 0)),
        ((-1, 0, 0), (0, 1, 0)),
        ((2, 0, 0), (0, 0, -1)),
        ((0, 1, 0), (1, 0, 0)),
        ((0, 0, 1), (0, 0, 1)),
        ((1, 0, 1), (1, 0, 0)),  # about x first: +z to -y, then about z: -y to +x
        ((1, 1, 0), (0, -1, 0)),
        ((0.5, 0, 0), (0, -np.sqrt(0.5), np.sqrt(0.5))),
    ],
)
def test_rotations_are_quarter_turns_about_x_then_y_then_z(rotation, axis):
    R = quarter_turns(rotation)
    np.testing.assert_allclose(R @ (0, 0, 1), axis, atol=1e-15)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(R) == pytest.approx(1)


@pytest.mark.parametrize("part", ALL, ids=["sphere", "ellipsoid", "cone", "cylinder"])
def test_corners_run_counter_clockwise_and_normals_point_outwards(part):
    part = part.without_slivers()
    edges = part.corners[:, 1:] - part.corners[:, :1]
    across = np.cross(edges[:, 0], edges[:, 1])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    np.testing.assert_allclose(np.linalg.norm(part.normals, axis=2), 1, atol=1e-12)
    assert (across[:, None] * part.normals).sum(axis=2).min() > 0.98
    middle = part.corners.reshape(-1, 3).mean(axis=0)
    assert ((part.corners - middle) * part.normals).sum(axis=2).mean() > 0


def test_sphere_is_round_to_a_thousandth():
    part = ALL[0]
    middles = np.linalg.norm(part.corners.mean(axis=1) - (1, 2, 3), axis=1)
    assert 4 * 0.998 < middles.min() < middles.max() < 4


def test_textures_repeat_a_whole_number_of_times_around_solids():
    for part in ALL:
        around = np.ptp(part.uv[..., 0])
        assert around >= 1
        assert around == round(around)


def test_degenerate_triangles_are_left_out():
    pointed = CylinderVisual(radius_base=0, radius_top=3, height=4, translation=(0, 4, 0))
    part = cylinder_triangles(pointed, TILE)
    kept = part.without_slivers()
    assert len(part.corners) - len(kept.corners) == 96


def test_points_inside_solids_are_found():
    points = np.array(
        [[20, 10.9, -5], [20, 7.1, 1.8], [20, 10.9, 1.8], [20, 6.9, -5], [20, 11.1, -5]]
    )
    np.testing.assert_array_equal(contains(CONE, points), [True, True, False, False, False])
    ball = EllipsoidVisual(centre=(0, 0, 0), radii=(1, 2, 3))
    inside = contains(ball, np.array([[0, 1.9, 0], [1.9, 0, 0], [0, 0, -2.9]]))
    np.testing.assert_array_equal(inside, [True, False, True])
    assert not contains(MeshVisual(file="rock.ply"), points).any()


TETRAHEDRON = """\
ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 4
property list uchar int vertex_indices
end_header
0 0 0 255 0 0
1 0 0 255 0 0
0 1 0 255 0 0
0 0 1 255 0 0
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
"""


def test_mesh_keeps_its_colours(tmp_path):
    (tmp_path / "rock.ply").write_text(TETRAHEDRON)
    part = read_mesh(tmp_path / "rock.ply")
    assert part.corners.shape == (4, 3, 3)
    np.testing.assert_array_equal(part.colours[0], [[1, 0, 0]] * 3)


def test_invalid_mesh_file_is_rejected(tmp_path):
    (tmp_path / "rock.ply").write_text("no mesh")
    with pytest.raises(InputError, match=r"rock\.ply: no triangle can be read, but at least"):
        read_mesh(tmp_path / "rock.ply")
