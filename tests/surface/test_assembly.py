"""Meshes of regions assembled into one surface, in memory or on disk."""

import numpy as np
import pytest
from views import RIG, ball_view, mesh_of, view_of, wall_view

from recon.exports.formats import write
from recon.exports.ply import write_mesh_parts
from recon.records import Mesh
from recon.surface.assembly import Assembly, MeshParts, RegionMesh
from recon.surface.breaks import unsure_at_breaks
from recon.surface.closing import border_edges
from recon.surface.volume import Volume

VOXEL = 0.04


@pytest.fixture(scope="module")
def volume():
    """A ball that spans eight regions."""
    found = Volume(VOXEL)
    for angle in range(0, 360, 60):
        found.add(ball_view(angle, noise=0.005, sigma=0.01))
    assert len(found.pages.keys) >= 8
    return found


def assembled(volume, folder=None, share=0.01):
    assembly = Assembly(share, folder)
    for region in volume.regions():
        colours = np.rint(100 + 50 * region.vertices).astype(np.uint8)
        assembly.add(region, colours)
    return assembly.finish()


def test_regions_join_into_one_piece_without_seams(volume):
    parts = assembled(volume)
    mesh = parts.whole
    assert sum(len(part.vertices) > 0 for part in parts) >= 8
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices) == parts.num_vertices
    assert len(mesh) == len(parts)
    assert parts.area == pytest.approx(mesh.area)
    assert parts.largest_share > 0.99
    # Borders remain only around the poles, which no camera sees.
    edges = mesh.vertices[border_edges(mesh)].mean(axis=1)
    assert (np.abs(edges[:, 1]) > 0.6).all()
    np.testing.assert_array_equal(mesh.colours, np.rint(100 + 50 * mesh.vertices))
    outwards = (mesh.normals * mesh.vertices).sum(axis=1)
    assert np.quantile(outwards, 0.02) > 0.8


def test_parts_on_disk_are_written_as_the_whole_in_memory(volume, tmp_path):
    stored = assembled(volume, tmp_path / "parts")
    write_mesh_parts(tmp_path / "a.ply", stored, (stored.num_vertices, len(stored)))
    write(assembled(volume).whole, tmp_path / "b.ply")
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()
    assert len(list((tmp_path / "parts").iterdir())) >= 8


def region_of(corner, is_shared):
    """A right triangle; its first vertex may be shared."""
    vertices = np.array([[0, 0, 0], corner, [corner[0], 1, 0]], np.float32)
    triangles = np.array([[0, 1, 2]], np.int32)
    return RegionMesh(
        vertices, np.zeros_like(vertices), triangles, np.array([is_shared, 0, 0], bool)
    )


@pytest.mark.parametrize(("is_shared", "left"), [(True, 2), (False, 1)])
def test_small_piece_is_kept_only_as_part_of_a_large_one(is_shared, left):
    assembly = Assembly(0.3)
    for corner in ((9.0, 0, 0), (-1.0, 0, 0)):
        assembly.add(region_of(corner, is_shared), np.zeros((3, 3), np.uint8))
    parts = assembly.finish()
    assert len(parts) == left
    assert parts.num_vertices == (5 if is_shared else 3)
    assert parts.area == pytest.approx(5.0 if is_shared else 4.5)


def test_coarse_mesh_approximates_the_surface(volume):
    parts = assembled(volume)
    coarse = parts.coarse(2_000)
    assert 500 < len(coarse) < 2_500
    assert coarse.area == pytest.approx(parts.area, rel=0.15)
    assert np.abs(np.linalg.norm(coarse.vertices, axis=1) - 1).max() < 0.1
    assert len(parts.coarse(10**6)) == len(parts)


def test_no_regions_give_an_empty_mesh():
    assert len(Assembly().finish().whole) == len(MeshParts.of(Mesh.none())) == 0
    assert len(mesh_of(Volume(VOXEL))) == 0


def test_depths_next_to_a_discontinuity_are_uncertain():
    view = wall_view(4.0)
    depth = view.depth.copy()
    depth[:, 40:] = 2.0
    sigma = unsure_at_breaks(view_of(depth, np.eye(4), 0.01)).sigma
    assert (sigma[:, 38:42] > 5 * 0.01).all()
    np.testing.assert_allclose(np.delete(sigma, slice(38, 42), axis=1), 0.01)


def test_slanted_planes_and_holes_are_not_discontinuities():
    columns = np.arange(96, dtype=float)
    depth = RIG.depth(np.broadcast_to(2.0 + 0.2 * columns, (80, 96))).copy()
    depth[10:20, 30:50] = np.nan
    sigma = unsure_at_breaks(view_of(depth, np.eye(4), 0.01)).sigma
    np.testing.assert_allclose(sigma[np.isfinite(depth)], 0.01)
