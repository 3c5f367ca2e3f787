"""Foreign Parquet, NPZ, NPY, Zarr and LAS files; attributes kept between formats."""

import logging
import subprocess
import sys

import numpy as np
import pytest
import pyvista

from recon.errors import InputError
from recon.exports import read, write
from recon.notices import collected_notices
from recon.records import PointCloud
from tests.exports.maps import sample_cloud

KEEPING = [".ply", ".pcd", ".las", ".laz", ".parquet", ".npz", ".npy", ".zarr", ".csv"]
UTM = np.array([[500123.456, 5412345.678, 312.001], [500124.457, 5412346.679, 313.002]])


def surveyed_cloud(**changes):
    """Make two points with all attributes of a survey."""
    attributes = {
        "intensity": np.array([7, 60000], np.uint16),
        "classification": np.array([2, 6], np.uint8),
        "label": np.array([-1, 40000], np.int32),
        "gps_time": np.array([3.1e8 + 0.000001, 3.1e8]),
        "nx": np.array([0.0, 0.6], np.float32),
        "ny": np.array([1.0, 0.0], np.float32),
        "nz": np.array([0.0, 0.8], np.float32),
    }
    return PointCloud(points=UTM, attributes=attributes, **changes)


@pytest.mark.parametrize("ending", KEEPING)
@pytest.mark.parametrize("colours", [None, np.array([[1, 2, 3], [255, 0, 9]], np.uint8)])
def test_attributes_are_kept_by_name(tmp_path, ending, colours):
    cloud = surveyed_cloud(colours=colours)
    with collected_notices() as notices:
        write(cloud, tmp_path / f"cloud{ending}")
        again = read(tmp_path / f"cloud{ending}")
    assert [one.code for one in notices if one.code != "turned-to-y-up"] == []
    assert np.abs(again.points - UTM).max() <= (1e-7 if ending in (".las", ".laz") else 0.0)
    assert set(again.attributes) == set(cloud.attributes)
    for name, values in cloud.attributes.items():
        assert np.array_equal(again.attributes[name], values), name
    assert (again.colours is None) == (colours is None)
    assert colours is None or np.array_equal(again.colours, colours)


@pytest.mark.parametrize("ending", [".las", ".ply", ".pcd", ".parquet", ".npz"])
def test_fractional_intensity_keeps_its_name(tmp_path, ending):
    cloud = PointCloud(points=UTM, attributes={"intensity": np.array([0.5, 0.7], np.float32)})
    write(cloud, tmp_path / f"cloud{ending}")
    again = read(tmp_path / f"cloud{ending}").attributes
    assert list(again) == ["intensity"]
    assert np.array_equal(again["intensity"], cloud.attributes["intensity"])


@pytest.mark.parametrize("ending", [".pts", ".glb"])
def test_lost_attributes_are_reported(tmp_path, ending):
    with collected_notices() as notices:
        write(surveyed_cloud(), tmp_path / f"cloud{ending}")
    [notice] = notices
    assert notice.code == "columns-dropped"
    assert "classification" in notice.text
    assert "nx" in notice.text


def test_ply_converts_or_rejects_64_bit_integers(tmp_path):
    attributes = {"id": np.array([1, 2**60 + 1]), "small": np.array([1, 2**40])}
    with collected_notices() as notices:
        write(PointCloud(points=UTM, attributes=attributes), tmp_path / "cloud.ply")
    assert [one.text.split(": ")[1] for one in notices] == ["cannot hold id; left out"]
    assert read(tmp_path / "cloud.ply").attributes["small"].tolist() == [1, 2**40]


def test_normals_rotate_with_the_points(tmp_path):
    laspy = pytest.importorskip("laspy")
    write(surveyed_cloud(), tmp_path / "cloud.las")
    file = laspy.read(tmp_path / "cloud.las")
    assert np.abs(np.column_stack([file.x, file.z, -np.asarray(file.y)]) - UTM).max() < 1e-7
    assert np.array_equal(file["nz"], np.array([1.0, 0.0], np.float32))
    assert np.array_equal(file["ny"], -np.array([0.0, 0.8], np.float32))


@pytest.mark.parametrize("version", ["1.2", "1.4"])
def test_las_to_las_keeps_axes_and_reference_system(tmp_path, version):
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(point_format=1 if version == "1.2" else 6, version=version)
    header.offsets, header.scales = [5e5, 5.4e6, 0], [0.001, 0.001, 0.001]
    wkt = b'PROJCS["WGS 84 / UTM zone 32N"]\0'
    record = laspy.VLR("LASF_Projection", 2112, record_data=wkt)
    if version == "1.2":
        keys = np.array([1, 1, 0, 1, 3072, 0, 1, 32632], "<u2").tobytes()
        record = laspy.VLR("LASF_Projection", 34735, record_data=keys)
    header.vlrs.append(record)
    file = laspy.LasData(header)
    file.x, file.y, file.z = UTM.T
    file.classification[:] = [2, 6]
    file.write(tmp_path / "in.las")
    write(read(tmp_path / "in.las"), tmp_path / "out.las")
    again = laspy.read(tmp_path / "out.las")
    assert np.abs(np.column_stack([again.x, again.y, again.z]) - UTM).max() < 1e-7
    assert again.classification.tolist() == [2, 6]
    [kept] = [one for one in again.header.vlrs if one.user_id == "LASF_Projection"]
    assert kept.record_id == record.record_id
    assert kept.record_data_bytes() == record.record_data_bytes()


def test_lost_reference_system_is_reported(tmp_path, caplog):
    from recon.records import Crs

    with caplog.at_level(logging.WARNING):
        write(surveyed_cloud(crs=Crs(records=((2112, b"WKT"),))), tmp_path / "cloud.ply")
    assert "cannot hold the coordinate reference system" in caplog.text


def test_large_coordinates_survive_in_glb(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    write(surveyed_cloud(), tmp_path / "cloud.glb")
    scene = trimesh.load_scene(tmp_path / "cloud.glb")
    [shape] = scene.dump()
    assert np.abs(np.asarray(shape.vertices) - UTM).max() < 1e-6
    [place] = scene.graph.nodes_geometry
    assert np.array_equal(scene.graph[place][0][:3, 3], np.rint(UTM.mean(axis=0)))
    assert np.abs(read(tmp_path / "cloud.glb").points - UTM).max() < 1e-6


def write_parquet(path, **columns):
    arrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet as library

    library.write_table(arrow.table(columns), path)
    return path


@pytest.mark.parametrize(
    ("colours", "expected"),
    [
        ([[1.0, 0.5, 0.0], [0.0, 0.8, 0.2]], [[255, 128, 0], [0, 204, 51]]),
        (np.array([[51200, 0, 65535], [256, 512, 1024]], np.uint16), [[199, 0, 255], [1, 2, 4]]),
        (np.array([[255, 128, 0], [1, 2, 3]], np.int64), [[255, 128, 0], [1, 2, 3]]),
    ],
)
def test_foreign_parquet_is_read(tmp_path, colours, expected):
    red, green, blue = np.array(colours).T
    path = write_parquet(
        tmp_path / "a.parquet", X=[1, 4], Y=[2.0, 5.0], Z=[3.0, 6.0], Red=red, Green=green,
        Blue=blue, name=["a", "b"], time=[0.5, None],
    )  # fmt: skip
    with collected_notices() as notices:
        cloud = read(path)
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.colours.tolist() == expected
    assert cloud.attributes["time"][0] == 0.5
    assert np.isnan(cloud.attributes["time"][1])
    assert [one.code for one in notices] == ["columns-dropped"]


def test_parquet_row_without_coordinates_is_left_out(tmp_path):
    path = write_parquet(tmp_path / "a.parquet", x=[1.0, None, 4.0], y=[2, 2, None], z=[3, 3, 3])
    assert read(path).points.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(
    ("arrays", "points", "colours"),
    [
        ({"points": [[1, 2, 3]], "colors": np.array([[0.5, 0, 1]])}, [1, 2, 3], [128, 0, 255]),
        ({"xyz": [[1, 2, 3]], "rgb": np.array([[9, 8, 7]], np.uint8)}, [1, 2, 3], [9, 8, 7]),
        ({"x": [1], "y": [2], "z": [3]}, [1, 2, 3], None),
        ({"X": [1], "Y": [2], "Z": [3]}, [1, 2, 3], None),
        ({"arr_0": np.array([[1.0, 2, 3, 255, 0, 7]])}, [1, 2, 3], [255, 0, 7]),
        ({"points": np.array([[1, 2, 3]], np.float16)}, [1, 2, 3], None),
    ],
)
def test_foreign_npz_is_read(tmp_path, arrays, points, colours):
    np.savez(tmp_path / "a.npz", **arrays)
    cloud = read(tmp_path / "a.npz")
    assert cloud.points.tolist() == [points]
    assert (None if cloud.colours is None else cloud.colours[0].tolist()) == colours


@pytest.mark.parametrize(
    "array",
    [
        np.array([[1.0, 2, 3], [4, 5, 6]]),
        np.asfortranarray(np.array([[1, 2, 3], [4, 5, 6]], ">f4")),
        np.array([[1.0, 2, 3, 0.25], [4, 5, 6, 0.5]]),
        np.array([[[1.0, 2, 3]], [[4, 5, 6]]]),
    ],
)
def test_foreign_npy_is_read(tmp_path, array):
    np.save(tmp_path / "a.npy", array)
    cloud = read(tmp_path / "a.npy")
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert set(cloud.attributes) <= {"intensity"}


@pytest.mark.parametrize(
    "array", [np.array([[1.0, 2]]), np.array(["a"]), np.array(3.0), np.zeros((48, 64))]
)
def test_npy_of_other_data_is_rejected(tmp_path, array):
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(InputError, match=r"a\.npy: "):
        read(tmp_path / "a.npy")


def test_sample_is_a_subset_in_order(tmp_path):
    write(sample_cloud(), tmp_path / "cloud.ply")
    part = read(tmp_path / "cloud.ply", sample=100)
    assert len(part) == 100
    assert np.array_equal(part.points, read(tmp_path / "cloud.ply", sample=100).points)
    where = [np.flatnonzero((sample_cloud().points == p).all(axis=1))[0] for p in part.points]
    assert sorted(set(where)) == where
    assert len(read(tmp_path / "cloud.ply", sample=10**6)) == 300


def test_foreign_e57_is_read(tmp_path):
    pye57 = pytest.importorskip("pye57")
    file = pye57.E57(str(tmp_path / "a.e57"), mode="w")
    # The writer stores 32-bit coordinates; the scanner's position makes them large.
    scan = {f"cartesian{axis}": np.array([1.5, 2.25]) + n for n, axis in enumerate("XYZ")}
    scan |= {"colorRed": np.array([255, 0], np.uint8), "colorGreen": np.array([9, 0], np.uint8)}
    scan |= {"colorBlue": np.array([0, 1], np.uint8), "intensity": np.array([0.5, 1.0])}
    file.write_scan_raw(scan, translation=UTM[0])
    file.close()
    cloud = read(tmp_path / "a.e57")
    x, y, z = UTM[0] + np.array([1.5, 2.5, 3.5])
    assert np.abs(cloud.points[0] - [x, z, -y]).max() < 1e-6
    assert cloud.colours.tolist() == [[255, 9, 0], [0, 0, 1]]
    assert cloud.attributes["intensity"].tolist() == [0.5, 1.0]
    whole = (tmp_path / "a.e57").read_bytes()
    (tmp_path / "a.e57").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="bytes are claimed, but the file has"):
        read(tmp_path / "a.e57")


def test_scans_of_an_e57_are_turned_and_moved_into_their_common_frame(tmp_path):
    pye57 = pytest.importorskip("pye57")
    file = pye57.E57(str(tmp_path / "a.e57"), mode="w")
    scan = {f"cartesian{axis}": np.array([float(n)]) for n, axis in enumerate("XYZ", 1)}
    quarter = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])  # w, x, y, z: from x to y
    file.write_scan_raw(scan, rotation=quarter, translation=np.array([10.0, 20.0, 30.0]))
    file.write_scan_raw(scan)
    file.close()
    turned, as_it_is = read(tmp_path / "a.e57").points
    np.testing.assert_allclose(turned, [8.0, 33.0, -21.0], atol=1e-6)
    np.testing.assert_allclose(as_it_is, [1.0, 3.0, -2.0], atol=1e-6)


def test_nan_cells_of_a_grid_are_left_out_with_a_notice(tmp_path):
    block = pyvista.ImageData(dimensions=(2, 3, 4))
    block["density"] = np.arange(24.0)
    block.save(tmp_path / "a.vti")
    with collected_notices() as notices:
        assert len(read(tmp_path / "a.vti")) == 23
    assert [notice.code for notice in notices] == ["places-left-out"]
    assert "1 of 24 positions" in notices[0].text


def test_transposed_points_are_rejected(tmp_path):
    np.save(tmp_path / "a.npy", np.arange(150.0).reshape(3, 50))
    with pytest.raises(InputError, match=r"shape \(3, 50\).*transpose"):
        read(tmp_path / "a.npy")


def test_points_are_read_without_compiling_map_kernels(tmp_path):
    (tmp_path / "a.xyz").write_text("1 2 3\n")
    code = (
        "import sys, recon.exports; recon.exports.read(sys.argv[1]);"
        "sys.exit('numba' in sys.modules or 'open3d' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "a.xyz")], check=True)
