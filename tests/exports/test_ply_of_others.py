"""PLY files of other programs: every variant is read correctly or rejected in one line."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.exports import read, read_mesh, write

XYZ = "property float x\nproperty float y\nproperty float z\n"
LIST = "property list uchar int vertex_indices\n"


def ply(path, header, body, form="ascii", newline="\n"):
    text = f"ply\nformat {form} 1.0\n{header}end_header\n".replace("\n", newline)
    path.write_bytes(text.encode() + (body if isinstance(body, bytes) else body.encode()))
    return path


@pytest.fixture
def path(tmp_path):
    return tmp_path / "cloud.ply"


def test_faces_before_the_vertices_are_skipped(path):
    head = f"element face 1\n{LIST}element vertex 3\n{XYZ}"
    cloud = read(ply(path, head, "3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n"))
    assert cloud.points.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert cloud.colours is None


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("corners", [(3, 3), (3, 4), (0, 5)])
def test_binary_faces_of_any_length_before_the_vertices_are_skipped(path, order, corners):
    faces = b"".join(
        np.array([n], "u1").tobytes() + np.arange(n, dtype=order + "i4").tobytes() for n in corners
    )
    points = np.arange(15, dtype=order + "f4").tobytes()
    form = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    head = f"element face 2\n{LIST}element vertex 5\n{XYZ}"
    cloud = read(ply(path, head, faces + points, form))
    assert cloud.points.ravel().tolist() == list(range(15))


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_list_properties_of_vertices_are_skipped(path, form):
    body = "1 2 3 2 7 8 9\n4 5 6 0 10\n"
    if form != "ascii":
        body = b"".join(
            np.array(row[:3], "<f4").tobytes()
            + np.array([len(ids)], "u1").tobytes()
            + np.array(ids, "<i4").tobytes()
            + np.array([row[3]], "<f4").tobytes()
            for row, ids in [((1, 2, 3, 9), [7, 8]), ((4, 5, 6, 10), [])]
        )
    head = f"element vertex 2\n{XYZ}property list uchar int ids\nproperty float time\n"
    cloud = read(ply(path, head, body, form))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.attributes["time"].tolist() == [9, 10]


@pytest.mark.parametrize(
    ("names", "kind", "rows", "colours"),
    [
        ("red green blue", "float", "1.0 0.5 0.0;0 0.8 0.2", [[255, 128, 0], [0, 204, 51]]),
        ("r g b", "uchar", "255 128 0;1 2 3", [[255, 128, 0], [1, 2, 3]]),
        ("Red Green Blue", "uchar", "255 0 0;0 255 0", [[255, 0, 0], [0, 255, 0]]),
        ("diffuse_red diffuse_green diffuse_blue", "uchar", "9 8 7;6 5 4", [[9, 8, 7], [6, 5, 4]]),
        ("red green blue", "ushort", "65535 0 512;257 0 0", [[255, 0, 2], [1, 0, 0]]),
        ("red green blue", "float", "255 0 7;1 2 3", [[255, 0, 7], [1, 2, 3]]),
        ("red green blue", "uchar", "1 1 0;0 1 1", [[1, 1, 0], [0, 1, 1]]),
    ],
)
def test_colours_of_any_name_and_scale_are_read(path, names, kind, rows, colours):
    properties = "".join(f"property {kind} {name}\n" for name in names.split())
    first, second = rows.split(";")
    head = f"element vertex 2\n{XYZ.replace('x', 'X')}{properties}"
    cloud = read(ply(path, head, f"1 2 3 {first}\n4 5 6 {second}\n"))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.colours.tolist() == colours
    assert cloud.attributes == {}


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_any_line_endings_are_read(path, newline):
    head = f"comment made by hand\nobj_info num_cols 2\nelement vertex 2\n{XYZ}"
    text = read(ply(path, head, newline.join(["1 2 3", "", "4 5 6"]), newline=newline))
    assert text.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    body = np.array([10, 13, 3, 4, 5, 6], "<f4").tobytes()
    binary = read(ply(path, head, body, "binary_little_endian", newline))
    assert binary.points.tolist() == [[10, 13, 3], [4, 5, 6]]


@pytest.mark.parametrize("word", ["nan", "-nan", "NaN", "-nan(ind)", "1.#QNAN", "-1.#IND00"])
def test_organised_cloud_keeps_the_measured_points(path, word):
    cloud = read(ply(path, f"element vertex 3\n{XYZ}", f"1 2 3\n{word} {word} {word}\n4 5 6\n"))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_other_properties_become_attributes_of_their_type(path):
    head = f"element vertex 1\n{XYZ}property float nx\nproperty ushort intensity\n"
    cloud = read(ply(path, head + "property int label\nproperty double time\n", "1 2 3 1 4 -5 .1"))
    assert {n: (v.dtype.name, v.item()) for n, v in cloud.attributes.items()} == {
        "nx": ("float32", 1.0), "intensity": ("uint16", 4), "label": ("int32", -5),
        "time": ("float64", 0.1),
    }  # fmt: skip
    write(cloud, path)
    again = read(path)
    assert {n: (v.dtype.name, v.item()) for n, v in again.attributes.items()} == {
        n: (v.dtype.name, v.item()) for n, v in cloud.attributes.items()
    }


@pytest.mark.parametrize(
    ("head", "body", "message"),
    [
        (f"element vertex 3\n{XYZ}", "1 2 3\n4 5 6\n", "3 of vertex are claimed, but 2 follow"),
        (f"element vertex 2\n{XYZ}", "1 2 3\n4 5 six\n", "'six' is not a number"),
        (f"element vertex 2\n{XYZ}", "1 2 3\n4 5\n", "has 2 values, but the first row has 3"),
        (f"element vertex 2\n{XYZ}", "1 2 3 4\n4 5 6 7\n", "a row has 4 values, but 3 are"),
        (f"element vertex 1\n{XYZ}", "1e308 0 0\n", r"x is 1e\+308, but float32"),
        (f"element vertex 1\n{XYZ}", "1e30 0 0\n", r"a coordinate is 1e\+30, but at most 1e\+15"),
        (f"element vertex -1\n{XYZ}", "", "it claims -1 of vertex"),
        (f"element vertex 1e9\n{XYZ}", "", "not a PLY file of vertices"),
        (f"element vertex 99999999999\n{XYZ}", "1 2 3\n", "99999999999 of vertex are claimed"),
        (f"element vertex 1\n{XYZ}property uchar red\n", "1 2 3 300\n", "red is 300, but uint8"),
        (f"element vertex 1\n{XYZ}property uchar red\n", "1 2 3 nan\n", "red is nan, but uint8"),
        ("element vertex 1\nproperty long x\n", "1\n", "not a PLY file of vertices"),
        (f"element face 1\n{LIST}", "3 0 1 2\n", "it has no vertices"),
        (f"element vertex 1\n{XYZ}element face 1\n{LIST}", "0 0 0\n3 0 1 9\n", "names vertex 9"),
        (f"element vertex 1\n{XYZ}element face 1\n{LIST}", "0 0 0\n3 0 0 -7\n", "vertex -7"),
        (f"element vertex 1\n{XYZ}element face 1\n{LIST}", "0 0 0\n9 0 0\n", "a row of face"),
        (f"element vertex 1\n{XYZ}element face 1\n{LIST}", "0 0 0\nnan 0 0\n", "a row of face"),
        (f"element vertex 1\n{XYZ}element face 1\n{LIST}", "0 0 0\ninf 0 0\n", "a row of face"),
    ],
)
def test_invalid_ply_is_rejected_in_one_line(path, head, body, message):
    with pytest.raises(InputError, match=message) as error:
        read(ply(path, head, body))
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("length", [b"\xff\xff\xff\x7f", b"\xff\xff\xff\xff"])
def test_list_longer_than_the_file_is_rejected(path, length):
    head = f"element vertex 1\n{XYZ}element face 1\nproperty list int int vertex_index\n"
    body = np.zeros(3, "<f4").tobytes() + length
    with pytest.raises(InputError, match=r"a list of -?\d+ values is claimed"):
        read(ply(path, head, body, "binary_little_endian"))


def test_mixed_polygons_are_triangulated(path):
    head = f"element vertex 5\n{XYZ}property uchar red\nproperty uchar green\n"
    head += f"property uchar blue\nelement face 2\n{LIST}"
    rows = "".join(f"{n} {n * n} 0 {n} 0 0\n" for n in range(5))
    mesh = read_mesh(ply(path, head, rows + "3 0 1 2\n4 0 2 3 4\n"))
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4]]
    assert mesh.colours[:, 0].tolist() == [0, 1, 2, 3, 4]
    write(mesh, path)
    again = read_mesh(path)
    assert np.array_equal(again.triangles, mesh.triangles)
    assert np.array_equal(again.vertices, mesh.vertices)
    assert np.array_equal(again.colours, mesh.colours)


def test_blanks_and_comments_near_the_end_of_the_header_are_read(path):
    head = f"comment end_header is near\nelement vertex 2\n{XYZ}".replace("\n", " \n")
    text = f"ply \nformat ascii 1.0 \n{head}end_header \n1 2 3 \n4 5 6 \n"
    for newline in ("\n", "\r\n", "\r"):
        path.write_bytes(text.replace("\n", newline).encode())
        np.testing.assert_array_equal(read(path).points, [[1, 2, 3], [4, 5, 6]])


def test_two_vertex_elements_are_rejected(path):
    head = f"element vertex 1\n{XYZ}element vertex 1\n{XYZ}"
    with pytest.raises(InputError, match="two of its elements have the same name"):
        read(ply(path, head, "1 2 3\n4 5 6\n"))


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_byte_order_mark_is_skipped(path, newline):
    ply(path, f"element vertex 1\n{XYZ}", f"1 2 3{newline}", newline=newline)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert read(path).points.tolist() == [[1, 2, 3]]
