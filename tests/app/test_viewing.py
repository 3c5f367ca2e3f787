"""Drawing and picking of the inspector, without a page."""

from io import BytesIO
from zipfile import ZipFile

import numpy as np
import pytest

from recon.app.archive import archive
from recon.app.drawing import draw, point_side
from recon.app.filters import Filter, shown
from recon.app.layers import layer_of
from recon.app.looks import Look
from recon.app.orbit import Orbit
from recon.app.taking import packed
from recon.exports.formats import read
from recon.records import Mesh, PointCloud
from recon.voxelmap import VoxelMap

SIZE = (320, 240)


@pytest.fixture(scope="module")
def cloud():
    rng = np.random.default_rng(1)
    points = rng.random((5000, 3)) * (10.0, 4.0, 6.0)
    colours = rng.integers(0, 256, (5000, 3)).astype(np.uint8)
    return PointCloud(points=points, colours=colours, sigma=rng.random(5000))


@pytest.fixture(scope="module")
def voxels(cloud):
    voxel_map = VoxelMap(cell_size=0.5)
    voxel_map.insert(cloud)
    return voxel_map.occupied(min_count=1)


def test_every_pixel_maps_to_its_row(cloud, voxels):
    for data in (cloud, voxels):
        layer = layer_of(data)
        orbit = Orbit.round(*layer.box)
        view = draw(layer, shown(layer, np.ones(len(layer), bool), 10**6), orbit, Look(), SIZE)
        rows = np.unique(view.number[view.number >= 0])
        assert len(rows) > 50
        v, u = np.nonzero(view.number >= 0)
        at = view.lens.project(layer.places[view.number[v, u]])
        reach = 3.0 if data is cloud else 30.0
        assert (np.hypot(at[:, 0] - u, at[:, 1] - v) < reach).all()
        assert view.row_at(u[0], v[0]) == view.number[v[0], u[0]]
        assert view.row_at(0, 0) is None


def test_nearer_points_occlude_farther_ones():
    points = np.array([[0.0, 0, 0], [0.0, 0, -5.0]])
    colours = np.array([[250, 0, 0], [0, 250, 0]], np.uint8)
    for order in ([0, 1], [1, 0]):
        layer = layer_of(PointCloud(points=points[order], colours=colours[order]))
        orbit = Orbit(target=np.zeros(3), distance=10.0, azimuth=0.0, elevation=0.0)
        view = draw(layer, shown(layer, np.ones(2, bool), 10), orbit, Look(), SIZE)
        middle = view.row_at(SIZE[0] / 2, SIZE[1] / 2)
        np.testing.assert_array_equal(layer.places[middle], [0, 0, 0])


def test_few_points_are_visible():
    layer = layer_of(PointCloud(points=np.diag([4.0, 2.0, 3.0])))
    for is_quick in (False, True):
        look = Look(is_quick=is_quick)
        view = draw(layer, shown(layer, np.ones(3, bool), 10), Orbit.round(*layer.box), look)
        found, counts = np.unique(view.number[view.number >= 0], return_counts=True)
        assert found.tolist() == [0, 1, 2]
        assert counts.min() >= 60
    assert point_side(100_000, 960 * 720) == 2


def test_mesh_is_drawn_without_gaps_and_can_be_picked():
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0.0]])
    mesh = Mesh(vertices=corners, triangles=np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    layer = layer_of(mesh)
    orbit = Orbit(target=np.zeros(3), distance=6.0, azimuth=0.0, elevation=0.0)
    view = draw(layer, shown(layer, np.ones(4, bool), 10), orbit, Look(), SIZE)
    u, v, _ = view.lens.project(corners).T
    inside = view.number[int(v.min()) + 2 : int(v.max()) - 1, int(u.min()) + 2 : int(u.max()) - 1]
    assert (inside >= 0).all()
    assert (view.number[:, : int(u.min()) - 1] == -1).all()


def test_filters_report_their_share(voxels):
    layer = layer_of(voxels)
    kept = Filter(least={"count": 3}).kept(layer)
    np.testing.assert_array_equal(kept, voxels.counts >= 3)
    text = shown(layer, kept, 10**6).share("cells")
    assert text.startswith(f"shows {kept.sum():,} of {len(voxels):,} cells")
    few = shown(layer, kept, 20)
    assert len(few.rows) == 20
    assert kept[few.rows].all()
    assert "drawn at random" in few.share("cells")
    low, high = np.array([0.0, 0, 0]), np.array([5.0, 2, 3])
    clipped = Filter(low=low, high=high).kept(layer)
    np.testing.assert_array_equal(
        clipped, ((voxels.centres >= low) & (voxels.centres <= high)).all(axis=1)
    )


def test_unknown_sigmas_pass_the_filter(cloud):
    sigma = np.where(np.arange(5000) < 10, np.nan, cloud.sigma)
    layer = layer_of(PointCloud(points=cloud.points, colours=cloud.colours, sigma=sigma))
    kept = Filter(most={"sigma": 0.5}).kept(layer)
    assert kept[:10].all()
    np.testing.assert_array_equal(kept[10:], sigma[10:] <= 0.5)


def test_downloads_are_read_back(voxels, tmp_path):
    for ending in (".ply", ".vti", ".npz"):
        name, content = packed(voxels, "part", ending)
        (tmp_path / name).write_bytes(content)
        again = read(tmp_path / name)
        number = again.num_cells if isinstance(again, VoxelMap) else len(again)
        assert number == len(voxels)
    name, _ = packed(voxels, "part", ".pgm")
    assert name == "part.pgm.zip"
    # Without the time of day, which a second archive made at once would have, too.
    (member,) = ZipFile(BytesIO(archive({"a": b"1"}))).infolist()
    assert member.date_time == (1980, 1, 1, 0, 0, 0)


def test_orbit_rotates_about_its_target():
    orbit = Orbit.round(np.zeros(3), np.ones(3))
    for other in (orbit.turned(50, -20), orbit.zoomed(2), orbit.seen_from("top")):
        np.testing.assert_array_equal(other.target, orbit.target)
    assert orbit.zoomed(3).distance < orbit.distance
    assert orbit.turned(0, 1e9).elevation < np.pi / 2
    moved = orbit.moved(10, 0, 240)
    assert np.linalg.norm(moved.position - orbit.position) > 0
    np.testing.assert_allclose(moved.position - moved.target, orbit.position - orbit.target)
