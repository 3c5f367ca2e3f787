"""PCD files as ROS and the Point Cloud Library write them."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.exports import read, write
from recon.libraries import load_open3d
from tests.exports.maps import sample_cloud


def pcd(path, fields, body, layout="ascii", num=2, **lines):
    """Write a PCD file with fields "name:type:size:count"."""
    names, kinds, sizes, counts = zip(*(one.split(":") for one in fields.split()), strict=True)
    keys = {
        "VERSION": "0.7", "FIELDS": " ".join(names), "SIZE": " ".join(sizes),
        "TYPE": " ".join(kinds), "COUNT": " ".join(counts), "WIDTH": num, "HEIGHT": 1,
        "VIEWPOINT": "0 0 0 1 0 0 0", "POINTS": num,
    } | lines  # fmt: skip
    text = "# .PCD v0.7 - Point Cloud Data file format\n"
    text += "".join(f"{key} {value}\n" for key, value in keys.items() if value is not None)
    content = body if isinstance(body, bytes) else body.encode()
    path.write_bytes(text.encode() + f"DATA {layout}\n".encode() + content)
    return path


XYZ = "x:F:4:1 y:F:4:1 z:F:4:1"


@pytest.fixture
def path(tmp_path):
    return tmp_path / "cloud.pcd"


def test_padding_as_ros_writes_it_is_skipped(path):
    dtype = [("xyz", "<f4", 3), ("a", "u1", 4), ("rgb", "<u4"), ("b", "u1", 12)]
    rows = np.zeros(2, dtype)
    rows["xyz"], rows["rgb"] = [[1, 2, 3], [4, 5, 6]], [0xFF8000, 0x010203]
    cloud = read(pcd(path, f"{XYZ} _:U:1:4 rgb:F:4:1 _:U:1:12", rows.tobytes(), "binary"))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.colours.tolist() == [[255, 128, 0], [1, 2, 3]]
    assert cloud.attributes == {}


def test_padding_in_text_is_skipped(path):
    body = "1 2 3 0 0 0 0 1\n4 5 6 0 0 0 0 1\n"
    cloud = read(pcd(path, f"{XYZ} _:U:1:4 normal_x:F:4:1", body))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert {n: v.tolist() for n, v in cloud.attributes.items()} == {"normal_x": [1, 1]}


@pytest.mark.parametrize(
    ("fields", "values", "colour"),
    [
        ("rgb:F:4:1", np.array([0xFF8000], "<u4").view("<f4")[0], [255, 128, 0]),
        ("rgb:U:4:1", 0xFF8000, [255, 128, 0]),
        ("rgb:I:4:1", 0xFF8000, [255, 128, 0]),
        ("rgba:U:4:1", 0xFFFF8000, [255, 128, 0]),
        ("r:U:1:1 g:U:1:1 b:U:1:1", "255 128 0", [255, 128, 0]),
        ("Red:U:1:1 Green:U:1:1 Blue:U:1:1", "255 128 0", [255, 128, 0]),
    ],
)
def test_every_encoding_of_colours_is_read(path, fields, values, colour):
    body = f"1 2 3 {values}\n4 5 6 {values}\n"
    assert read(pcd(path, f"{XYZ} {fields}", body)).colours.tolist() == [colour, colour]


@pytest.mark.parametrize("layout", ["binary", "binary_compressed"])
def test_pcd_written_by_open3d_is_read(path, layout):
    o3d = load_open3d()
    cloud = o3d.t.geometry.PointCloud(
        o3d.core.Tensor(np.arange(30, dtype=np.float32).reshape(-1, 3))
    )
    cloud.point["colors"] = o3d.core.Tensor(np.arange(30, dtype=np.uint8).reshape(-1, 3))
    cloud.point["normals"] = o3d.core.Tensor(np.ones((10, 3), np.float32))
    o3d.t.io.write_point_cloud(str(path), cloud, compressed=layout != "binary")
    found = read(path)
    assert found.points.ravel().tolist() == list(range(30))
    assert found.colours.ravel().tolist() == list(range(30))
    assert found.attributes["normal_x"].tolist() == [1] * 10


def test_open3d_reads_the_written_pcd(path):
    write(sample_cloud(num=20), path)
    cloud = load_open3d().t.io.read_point_cloud(str(path))
    assert np.abs(cloud.point["positions"].numpy() - sample_cloud(num=20).points).max() == 0.0


def test_organised_cloud_with_nan_is_read(path):
    body = "1 2 3\nnan nan nan\n4 5 6\n-nan nan nan\n"
    found = read(pcd(path, XYZ, body, num=4, WIDTH=2, HEIGHT=2))
    assert found.points.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_fields_of_several_values_get_numbered_names(path):
    found = read(pcd(path, f"{XYZ} vfh:F:4:2", "1 2 3 7 8\n4 5 6 9 10\n"))
    assert {n: v.tolist() for n, v in found.attributes.items()} == {
        "vfh_0": [7, 9],
        "vfh_1": [8, 10],
    }


@pytest.mark.parametrize("body", ["1  2\t3 \r\n4 5 6\r\n", "1 2 3\n\n4 5 6"])
def test_any_spaces_and_line_endings_are_read(path, body):
    assert read(pcd(path, XYZ, body)).points.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_header_lines_missing_in_old_versions_have_defaults(path):
    lines = {"VERSION": ".5", "COUNT": None, "VIEWPOINT": None, "HEIGHT": None}
    assert len(read(pcd(path, XYZ, "1 2 3\n4 5 6\n", **lines))) == 2


@pytest.mark.parametrize(
    ("body", "lines", "message"),
    [
        ("1 2 3\n", {}, "2 points are claimed, but 1 follow"),
        ("1 2 3\n4 5 six\n", {}, "'six' is not a number"),
        ("1 2 3\n4 5\n", {}, "has 2 values"),
        ("1 2 3\n4 5 6\n", {"POINTS": 4}, "claims 4 points, and 2 x 1"),
        ("1 2 3\n4 5 6\n", {"SIZE": "4 4 3"}, "a type is none of"),
        ("1 2 3\n4 5 6\n", {"SIZE": "4 4"}, "not a PCD file"),
        ("1 2 3\n4 5 6\n", {"COUNT": "1 1 1000000000"}, "not a PCD file"),
        ("1 2 3\n4 5 6\n", {"WIDTH": -2, "POINTS": -2}, "it is -2 x 1 points"),
        ("1 2 3\n4 5 6\n", {"FIELDS": "a b c"}, "but x is needed"),
        ("1 2 3\n4 5 6\n", {"NONSENSE": "1"}, "'NONSENSE' is not a line of its header"),
    ],
)
def test_invalid_pcd_is_rejected_in_one_line(path, body, lines, message):
    with pytest.raises(InputError, match=message) as error:
        read(pcd(path, XYZ, body, **lines))
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("layout", ["binary", "binary_compressed"])
@pytest.mark.parametrize("num", [2, 10**9, 10**15])
def test_missing_binary_points_are_rejected(path, layout, num):
    with pytest.raises(InputError, match=r"are claimed, but|GB of memory, but"):
        read(pcd(path, XYZ, b"\x01\x02", layout, num=num))
