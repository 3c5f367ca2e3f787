"""Meshes are closed where no view has seen them, without borders and with a thickness."""

import numpy as np
import pytest
import trimesh
from views import VOXEL, ball_view, mesh_of, wall_view

from recon.notices import collected_notices
from recon.records import Mesh
from recon.settings import SurfaceSettings
from recon.surface.closing import (
    border_edges,
    capped,
    edge_counts,
    thickness,
    watertight,
    without_touching,
)
from recon.surface.fusion import Fusion
from recon.surface.triangles import (
    mesh_of_pixels,
)
from recon.surface.volume import Volume


def half_ball():
    volume = Volume(VOXEL)
    for angle in (0, 30, 60):
        volume.add(ball_view(angle, noise=0.02, sigma=0.02))
    return mesh_of(volume)


@pytest.mark.parametrize("seen", ["ball", "half", "wall"])
def test_watertight_mesh_has_no_border(ball, seen):
    opened = {"ball": lambda: ball, "half": half_ball, "wall": lambda: mesh_of_pixels(wall_view())}
    mesh = opened[seen]()
    closed = watertight(mesh)
    assert len(border_edges(mesh)) > 20
    assert (edge_counts(closed) == 2).all()
    edges = closed.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    # Each edge occurs once in each direction: the mesh is closed and consistently oriented.
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(edge) for edge in edges} == {tuple(edge) for edge in edges[:, ::-1]}
    assert (closed.colours is None) == (mesh.colours is None)


def test_closed_ball_has_the_right_size(ball):
    closed = watertight(ball)
    # No view shows the top and bottom of the ball: the Poisson surface bulges there.
    assert closed.area == pytest.approx(4 * np.pi, rel=0.08)
    a, b, c = np.moveaxis(closed.corners, 1, 0)
    volume = (a * np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(4 / 3 * np.pi, rel=0.08)


def notices_of_watertight(views):
    """Collect the codes of the notices while a watertight mesh of views is made."""
    fusion = Fusion(SurfaceSettings(mesh=True, watertight=True, voxel=VOXEL))
    for view in views:
        fusion.add_view(view)
    with collected_notices() as notices:
        fusion.finish()
    return [notice.code for notice in notices]


def test_closed_sheet_without_thickness_is_reported(ball):
    assert thickness(watertight(ball)) == pytest.approx(2 / 3, rel=0.1)  # of a ball of radius 1
    assert notices_of_watertight([wall_view()]) == ["mesh-without-thickness"]
    assert notices_of_watertight([ball_view(angle) for angle in range(0, 360, 30)]) == []


def test_borders_that_share_a_vertex_are_capped_separately():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    pair = Mesh(vertices=vertices, triangles=np.array([[0, 1, 2], [0, 3, 4]], np.int32))
    closed = capped(pair)
    assert len(border_edges(pair)) == 6
    assert len(border_edges(closed)) == 0
    assert len(closed.vertices) == 7
    assert capped(closed) is closed


def test_surface_that_touches_itself_along_an_edge_is_closed():
    """Two boxes share an edge, whose four triangles are replaced by two caps."""
    box = trimesh.creation.box()
    vertices = np.concatenate([box.vertices, box.vertices + np.array([1.0, 1, 0])])
    places, number = np.unique(vertices, axis=0, return_inverse=True)
    triangles = number.reshape(-1)[np.concatenate([box.faces, box.faces + 8])].astype(np.int32)
    pair = Mesh(vertices=places, triangles=triangles)
    assert (edge_counts(pair) == 4).sum() == 4
    closed = capped(without_touching(pair))
    assert (edge_counts(closed) == 2).all()
    assert closed.area == pytest.approx(pair.area, rel=0.2)
