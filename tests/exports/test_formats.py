"""Every format by extension: round trips, and other readers."""

import dataclasses
import logging

import cv2
import numpy as np
import pytest
import yaml

from recon.errors import InputError
from recon.exports import read, write
from recon.libraries import load_open3d
from recon.records import PointCloud, Voxels
from recon.voxelmap import VoxelMap
from tests.exports.maps import (
    CELL_FORMATS,
    CHANNELS,
    CLOUD_FORMATS,
    GRID_FORMATS,
    same,
    sample_cloud,
    sample_map,
)


@pytest.mark.parametrize("with_sigma", [True, False])
@pytest.mark.parametrize("ending", CLOUD_FORMATS)
def test_clouds_round_trip(tmp_path, ending, with_sigma):
    cloud = sample_cloud(with_sigma=with_sigma)
    write(cloud, tmp_path / f"cloud{ending}")
    # LAS stores coordinates in steps of 1e-7.
    tolerance = 1e-7 if ending in (".las", ".laz") else 1e-13
    same(read(tmp_path / f"cloud{ending}"), cloud, tolerance)


@pytest.mark.parametrize("channels", [(), CHANNELS])
@pytest.mark.parametrize("ending", CELL_FORMATS)
def test_cells_round_trip_with_every_value(tmp_path, ending, channels):
    voxels = sample_map(channels).occupied(2)
    write(voxels, tmp_path / f"map{ending}")
    same(read(tmp_path / f"map{ending}"), voxels, 1e-7 if ending in (".las", ".laz") else 1e-13)


@pytest.mark.parametrize("ending", [e for e in CELL_FORMATS if e != ".npz"])
def test_all_cells_of_a_map_are_written(tmp_path, ending):
    voxel_map = sample_map()
    write(voxel_map, tmp_path / f"map{ending}")
    assert len(read(tmp_path / f"map{ending}")) == voxel_map.num_cells


def test_map_round_trips_exactly(tmp_path):
    voxel_map = sample_map()
    write(voxel_map, tmp_path / "map.npz")
    again = read(tmp_path / "map.npz")
    again.save(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "map.npz").read_bytes()


@pytest.mark.parametrize("ending", sorted({*CELL_FORMATS, *GRID_FORMATS, ".glb", ".csv", ".xyz"}))
def test_same_data_gives_the_same_bytes(tmp_path, ending):
    names = ("map.pgm", "map.yaml") if ending in (".pgm", ".yaml") else (f"map{ending}",)
    contents = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        write(sample_map(), folder / f"map{ending}")
        assert {path.name for path in folder.iterdir()} == set(names)
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        contents.append([path.read_bytes() for path in files])
    assert contents[0] == contents[1]


@pytest.mark.parametrize("ending", sorted({*CELL_FORMATS, ".bt", ".ot", ".csv"}))
def test_empty_map_is_written(tmp_path, ending):
    write(VoxelMap(), tmp_path / f"map{ending}")
    data = read(tmp_path / f"map{ending}")
    assert (data.num_cells if isinstance(data, VoxelMap) else len(data)) == 0


@pytest.mark.parametrize(
    ("ending", "message"),
    [(".pgm", "nothing of the map is at the height of a robot")],
)
def test_format_that_cannot_be_empty_rejects_an_empty_map(tmp_path, ending, message):
    with pytest.raises(InputError, match=message):
        write(VoxelMap(), tmp_path / f"map{ending}")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", [".bt", ".ot"])
def test_octomap_keeps_the_occupied_cells(tmp_path, ending):
    voxels = sample_map().occupied(2)
    write(voxels, tmp_path / f"map{ending}")
    again = read(tmp_path / f"map{ending}")
    assert np.array_equal(again.index, voxels.index)
    assert np.abs(again.centres - voxels.centres).max() < 1e-9
    if ending == ".ot":
        assert np.array_equal(again.colours, voxels.colours)


def test_octomap_reads_occupied_and_free_space_with_z_up(tmp_path):
    pyoctomap = pytest.importorskip("pyoctomap")
    voxel_map = VoxelMap(1.0, channels=["rays"])
    wall = PointCloud(points=np.array([[5.5, 2.5, 7.5]]), colours=np.zeros((1, 3), np.uint8))
    voxel_map.insert(wall, [0.5, 2.5, 7.5])
    write(voxel_map, tmp_path / "map.bt")
    tree = pyoctomap.OcTree(1.0)
    assert tree.readBinary(str(tmp_path / "map.bt"))
    for x, is_occupied in [(0.5, False), (4.5, False), (5.5, True)]:
        node = tree.search(np.array([x, -7.5, 2.5]))
        assert tree.isNodeOccupied(node) == is_occupied
    assert tree.search(np.array([6.5, -7.5, 2.5])) is None


@pytest.mark.parametrize("ending", [".las", ".laz"])
def test_las_has_z_up_and_named_values(tmp_path, ending):
    laspy = pytest.importorskip("laspy")
    voxels = sample_map().occupied(2)
    write(voxels, tmp_path / f"map{ending}")
    file = laspy.read(tmp_path / f"map{ending}")
    assert np.abs(np.sort(file.z) - np.sort(voxels.means[:, 1])).max() < 1e-7
    assert np.abs(np.sort(file.y) - np.sort(-voxels.means[:, 2])).max() < 1e-7
    assert file["count"].sum() == voxels.counts.sum()
    assert file.red.max() == 257 * int(voxels.colours[:, 0].max())


def test_change_of_axes_is_logged(tmp_path, caplog):
    with caplog.at_level(logging.INFO):
        write(sample_cloud(), tmp_path / "cloud.las")
        write(sample_cloud(), tmp_path / "cloud.ply")
        read(tmp_path / "cloud.las")
        read(tmp_path / "cloud.ply")
    assert [record.message.split(" has ")[1] for record in caplog.records] == [
        "z up: (x, y, z) was read as (x, z, -y)"
    ]


def test_open3d_reads_the_cells_of_a_ply(tmp_path):
    voxels = sample_map(()).occupied(1)
    write(voxels, tmp_path / "map.ply")
    cloud = load_open3d().t.io.read_point_cloud(str(tmp_path / "map.ply"))
    assert np.array_equal(cloud.point["positions"].numpy(), voxels.means)
    assert np.array_equal(cloud.point["count"].numpy().ravel(), voxels.counts)
    assert np.array_equal(cloud.point["index_y"].numpy().ravel(), voxels.index[:, 1])


def test_trimesh_reads_the_faces_of_a_glb(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    write(sample_map(()), tmp_path / "map.glb")
    scene = trimesh.load(tmp_path / "map.glb")
    [mesh] = scene.geometry.values()
    voxels = sample_map(()).occupied(1)
    low, high = voxels.index.min(axis=0) * 0.5, (voxels.index.max(axis=0) + 1) * 0.5
    assert np.allclose(mesh.bounds, [low, high])
    assert mesh.volume == pytest.approx(len(voxels) * 0.5**3)
    assert mesh.visual.material.metallicFactor == 0


def test_nav2_map_shows_free_occupied_and_unknown_ground(tmp_path):
    voxel_map = VoxelMap(1.0, channels=["rays"])
    points = np.array([[5.5, 2.5, 7.5], [0.5, 2.5, 9.5]])
    wall = PointCloud(points=points, colours=np.zeros((2, 3), np.uint8))
    voxel_map.insert(wall, [0.5, 2.5, 7.5])
    write(voxel_map, tmp_path / "map.yaml")
    image = cv2.imread(str(tmp_path / "map.pgm"), cv2.IMREAD_UNCHANGED)
    # Rows run from z = 7 to 9, starting at the largest -z.
    assert image.tolist() == [
        [254, 254, 254, 254, 254, 0],
        [254, 205, 205, 205, 205, 205],
        [0, 205, 205, 205, 205, 205],
    ]
    description = yaml.safe_load((tmp_path / "map.yaml").read_text())
    assert description["image"] == "map.pgm"
    assert description["origin"] == [0.0, -10.0, 0.0]
    assert description["resolution"] == 1.0


@pytest.mark.parametrize("turns", [0.0, 0.1, 0.25, -0.5, 1.3])
def test_yaw_of_a_nav2_origin_is_applied(tmp_path, turns):
    """A wall along the rows of the image is rotated by the yaw of the origin."""
    image = np.full((60, 60), 254, np.uint8)
    image[30:34, 10:50] = 0
    cv2.imwrite(str(tmp_path / "map.pgm"), image)
    yaw = 2 * np.pi * turns
    (tmp_path / "map.yaml").write_text(
        f"image: map.pgm\nresolution: 0.5\norigin: [3.0, -7.0, {yaw}]\n"
    )
    voxels = read(tmp_path / "map.yaml")
    # In nav2, (x, y) = origin + rotated (column, row from the bottom); y is -z here.
    along, up = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    middle = [3.0, -7.0] + 0.5 * (30 * along + 28 * up)
    offset = voxels.centres[:, [0, 2]] * [1, -1] - middle
    assert np.abs(offset @ along).max() < 10.0
    assert np.abs(offset @ up).max() < 1.0
    assert abs(len(voxels) - 160) <= 8
    assert np.allclose(offset.mean(axis=0), 0, atol=0.25)  # half a cell
    assert voxels.colours is None


@pytest.mark.parametrize("ending", [".ply", ".npz", ".bt", ".las", ".pgm"])
def test_box_keeps_the_cells_inside(tmp_path, ending):
    box = ([98.0, -1.0, -45.0], [102.0, 5.0, -38.0])
    voxel_map = sample_map()
    write(voxel_map, tmp_path / f"map{ending}", box=box)
    centres = voxel_map.occupied(1).centres
    inside = ((centres >= box[0]) & (centres <= box[1])).all(axis=1)
    assert 0 < inside.sum() < len(inside)
    if ending == ".npz":
        part = read(tmp_path / "map.npz")
        same(part.occupied(1), voxel_map.occupied(1).select(inside))
        middles = (part.sightings().index + 0.5) * 0.5
        assert (middles >= box[0]).all()
        assert (middles <= box[1]).all()
    elif ending == ".pgm":
        assert max(cv2.imread(str(tmp_path / "map.pgm")).shape) <= 14
    elif ending == ".bt":
        assert len(read(tmp_path / "map.bt")) <= inside.sum()
    else:
        assert len(read(tmp_path / f"map{ending}")) == inside.sum()


def test_box_keeps_the_points_inside(tmp_path):
    cloud = sample_cloud()
    write(cloud, tmp_path / "cloud.npz", box=([95, 0, -45], [105, 5, -35]))
    points = read(tmp_path / "cloud.npz").points
    assert 0 < len(points) < len(cloud)
    assert (points.min(axis=0) >= [95, 0, -45]).all()


def test_zarr_group_overwrites_only_a_zarr_group(tmp_path):
    path = tmp_path / "map.zarr"
    write(sample_map(), path)
    write(sample_cloud(), path)
    assert isinstance(read(path), PointCloud)
    assert list(tmp_path.iterdir()) == [path]
    other = tmp_path / "mine.zarr"
    other.mkdir()
    (other / "work.txt").write_text("mine")
    with pytest.raises(InputError, match="exists and is not a Zarr group"):
        write(sample_cloud(), other)
    assert (other / "work.txt").read_text() == "mine"


def test_every_field_of_voxels_has_a_column():
    voxels = sample_map().occupied(1)
    assert all(getattr(voxels, field.name) is not None for field in dataclasses.fields(Voxels))
