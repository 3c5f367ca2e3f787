"""Triangle meshes: foreign files, their vertices, sampled points, and writing."""

import json
import re
import struct

import numpy as np
import pytest

from recon.errors import InputError
from recon.exports import read, read_mesh, write
from recon.notices import collected_notices
from recon.records import Mesh

SQUARE = Mesh(
    vertices=np.array([[0.0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]]),
    triangles=np.array([[0, 1, 2], [0, 2, 3]], np.int32),
    colours=np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [9, 9, 9]], np.uint8),
)


@pytest.mark.parametrize("ending", [".ply", ".obj", ".glb", ".stl", ".off"])
def test_mesh_round_trips(tmp_path, ending):
    write(SQUARE, tmp_path / f"mesh{ending}")
    again = read_mesh(tmp_path / f"mesh{ending}")
    assert again.area == pytest.approx(6.0)
    assert len(again.vertices) == 4
    assert np.array_equal(again.corners, SQUARE.corners)
    if ending in (".ply", ".obj", ".glb"):
        assert np.array_equal(again.colours, SQUARE.colours)


@pytest.mark.parametrize("ending", [".ply", ".obj", ".glb", ".stl", ".off"])
def test_vertices_of_a_mesh_are_read_as_a_cloud(tmp_path, ending):
    write(SQUARE, tmp_path / f"mesh{ending}")
    cloud = read(tmp_path / f"mesh{ending}")
    assert sorted(cloud.points.tolist()) == sorted(SQUARE.vertices.tolist())


@pytest.mark.parametrize("ending", [".ply", ".obj"])
def test_sampled_points_are_uniform_over_the_surface(tmp_path, ending):
    write(SQUARE, tmp_path / f"mesh{ending}")
    cloud = read(tmp_path / f"mesh{ending}", sample=4000)
    assert len(cloud) == 4000
    quarters = np.floor(cloud.points[:, :2] / [1.0, 1.5]).astype(int)
    counts = np.bincount(2 * quarters[:, 0] + quarters[:, 1], minlength=4)
    assert 900 < counts.min() <= counts.max() < 1100
    assert np.array_equal(cloud.points, read(tmp_path / f"mesh{ending}", sample=4000).points)
    assert not np.array_equal(
        cloud.points, read(tmp_path / f"mesh{ending}", sample=4000, seed=1).points
    )
    near = np.linalg.norm(cloud.points - [0, 0, 0], axis=1) < 0.1
    assert cloud.colours[near, 0].min() > 200


@pytest.mark.parametrize(
    ("text", "triangles"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", [[0, 1, 2]]),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n", [[0, 1, 2]]),
        ("mtllib no.mtl\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl b\n"
         "f 1/1/1 2/1/1 3/1/1\n", [[0, 1, 2]]),
        ("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1//1 2//1 3//1 4//1\n", [[0, 1, 2], [0, 2, 3]]),
        ("v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 \\\n3\n", [[0, 1, 2]]),
    ],
)  # fmt: skip
def test_foreign_obj_is_read(tmp_path, text, triangles):
    (tmp_path / "a.obj").write_text(text)
    assert read_mesh(tmp_path / "a.obj").triangles.tolist() == triangles
    assert len(read(tmp_path / "a.obj")) == sum(line[:2] == "v " for line in text.splitlines())


def test_obj_with_vertex_colours_is_read(tmp_path):
    (tmp_path / "a.obj").write_text("v 1 2 3 1.0 0.5 0.0\nv 4 5 6 0 0 1\n")
    cloud = read(tmp_path / "a.obj")
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.colours.tolist() == [[255, 128, 0], [0, 0, 255]]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.obj", b"v 0 0 0\nf 1 2 3\n", "names vertex [12], but there are 1"),
        ("a.obj", b"v 0 0 0\nf 0 1 1\n", "indices start at 1"),
        ("a.obj", b"v 0 0 zero\n", "'zero' is not a number"),
        ("a.obj", b"v 0 0\n", "a vertex has 2 numbers"),
        ("a.obj", b"f 1 2 x\n", "a face is '1 2 x'"),
        ("a.obj", b"", "it holds no vertices"),
        ("a.stl", b"\0" * 80 + (10**9).to_bytes(4, "little"), "1000000000 triangles are claimed"),
        ("a.stl", b"solid a\nfacet normal 0 0 1\n", "its text has no end"),
        ("a.off", b"OFF\n1000000 5 0\n0 0 0\n", "vertices and faces are claimed"),
        ("a.off", b"no\n", "not an OFF file"),
        ("a.off", b"OFF" + b"9" * 5000 + b" 1 0\n", "not a whole OFF file"),
        ("a.glb", b"glTF\2\0\0\0\xff\xff\xff\xff", "bytes are claimed"),
    ],
)
def test_invalid_mesh_is_rejected_in_one_line(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message) as error:
        read(tmp_path / name)
    assert str(error.value).startswith(str(tmp_path / name))
    assert "\n" not in str(error.value)


def test_stl_too_coarse_for_its_coordinates_is_rejected(tmp_path):
    far = Mesh(vertices=SQUARE.vertices + 5e7, triangles=SQUARE.triangles)
    with pytest.raises(InputError, match="32-bit coordinates would move vertices"):
        write(far, tmp_path / "a.stl")
    write(far, tmp_path / "a.glb")
    assert np.abs(read_mesh(tmp_path / "a.glb").vertices - far.vertices).max() == 0.0


@pytest.mark.parametrize("ending", [".las", ".xyz", ".vti"])
def test_format_without_triangles_rejects_a_mesh(tmp_path, ending):
    with pytest.raises(InputError, match="cannot hold triangles; give --sample N"):
        write(SQUARE, tmp_path / f"a{ending}")


def test_foreign_vtk_is_read(tmp_path):
    import pyvista

    points = np.array([[1.0, 2, 3], [4, 5, 6]], np.float32)
    cloud = pyvista.PolyData(points)
    cloud["heat"] = [1.5, 2.5]
    for ending in (".vtk", ".vtp"):
        cloud.save(tmp_path / f"a{ending}")
        again = read(tmp_path / f"a{ending}")
        assert again.points.tolist() == points.tolist()
        assert again.attributes["heat"].tolist() == [1.5, 2.5]
    block = pyvista.ImageData(dimensions=(3, 2, 2), spacing=(0.5, 0.5, 0.5))
    block.cell_data["density"] = [0.0, 7.0]
    block.save(tmp_path / "a.vti")
    again = read(tmp_path / "a.vti")
    assert again.points.tolist() == [[0.75, 0.25, 0.25]]
    assert again.attributes["density"].tolist() == [7.0]


def test_ignored_colours_of_an_off_file_are_reported(tmp_path):
    (tmp_path / "a.off").write_text("COFF\n1 0 0\n1 2 3 255 0 0 255\n")
    with collected_notices() as notices:
        assert read(tmp_path / "a.off").points.tolist() == [[1, 2, 3]]
    assert {one.code for one in notices} == {"colour-missing"}


def test_faces_take_colours_from_the_materials_of_an_obj(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl sea blue\nKd 0 0 .2\n")
    text = "mtllib a.mtl\r\n" + "".join(f"v {x} 0 0\nv {x} 1 0\nv {x} 0 1\n" for x in (0, 1))
    (tmp_path / "a.obj").write_text(text + "usemtl red\nf 1 2 3\nusemtl sea blue\nf 4 5 6\n")
    mesh = read_mesh(tmp_path / "a.obj")
    np.testing.assert_array_equal(mesh.colours, 3 * [[255, 0, 0]] + 3 * [[0, 0, 51]])
    (tmp_path / "a.mtl").unlink()
    with collected_notices() as notices:
        assert read_mesh(tmp_path / "a.obj").colours is None
    assert [notice.code for notice in notices] == ["colour-missing"]


@pytest.mark.parametrize("name", ["../a.mtl", "/etc/passwd"])
def test_materials_outside_the_folder_are_not_read(tmp_path, name):
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\n")
    (tmp_path / "in").mkdir()
    (tmp_path / "in/a.obj").write_text(
        f"mtllib {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"
    )
    with collected_notices() as notices:
        assert read_mesh(tmp_path / "in/a.obj").colours is None
    assert "is not beside it" in notices[0].text


def test_obj_is_written_with_its_materials(tmp_path):
    corners = np.eye(3)
    mesh = Mesh(
        vertices=np.vstack([corners, corners + 5]),
        triangles=np.array([[0, 1, 2], [3, 4, 5]], np.int32),
        colours=np.repeat(np.array([[255, 0, 0], [0, 0, 255]], np.uint8), 3, axis=0),
    )
    write(mesh, tmp_path / "a.obj")
    again = read_mesh(tmp_path / "a.obj")
    np.testing.assert_array_equal(again.triangles, mesh.triangles)
    np.testing.assert_array_equal(again.colours, mesh.colours)
    plain = re.sub(r"(?m)^(v \S+ \S+ \S+).*$", r"\1", (tmp_path / "a.obj").read_text())
    (tmp_path / "a.obj").write_text(plain)
    np.testing.assert_array_equal(read_mesh(tmp_path / "a.obj").colours, mesh.colours)


def test_vertex_attributes_are_kept_in_ply_and_reported_as_lost_elsewhere(tmp_path):
    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nproperty float quality\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
        "0 0 0 .5\n1 0 0 .25\n0 1 0 .75\n3 0 1 2\n"
    )
    mesh = read_mesh(tmp_path / "a.ply")
    with collected_notices() as notices:
        write(mesh, tmp_path / "b.ply")
    again = read_mesh(tmp_path / "b.ply").attributes
    np.testing.assert_array_equal(again["quality"], np.array([0.5, 0.25, 0.75], np.float32))
    assert not notices
    for ending in ("obj", "stl", "glb"):
        with collected_notices() as notices:
            write(mesh, tmp_path / f"b.{ending}")
        assert [(n.code, "quality" in n.text) for n in notices] == [("columns-dropped", True)]


FACET = "facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n".format(
    "".join(f"vertex {x} {y} 0\n" for x, y in ((0, 0), (1, 0), (0, 1)))
)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.stl", f"SOLID\n{FACET.upper()}ENDSOLID\n"),
        ("a.stl", f"solid a\n{FACET}endsolid a\n"),
        ("a.off", "OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),  # as in ModelNet
        ("a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    ],
)
def test_variants_of_stl_and_off_are_read(tmp_path, name, content):
    (tmp_path / name).write_text(content)
    mesh = read_mesh(tmp_path / name)
    np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    assert mesh.triangles.tolist() == [[0, 1, 2]]


def test_glb_with_draco_compression_is_rejected(tmp_path):
    """Without this check, its arrays would be read as zeros."""
    write(Mesh(vertices=np.eye(3), triangles=np.array([[0, 1, 2]])), tmp_path / "a.glb")
    content = (tmp_path / "a.glb").read_bytes()
    length = int.from_bytes(content[12:16], "little")
    tree = json.loads(content[20 : 20 + length])
    text = json.dumps(tree | {"extensionsRequired": ["KHR_draco_mesh_compression"]}).encode()
    text += b" " * (-len(text) % 4)
    head = [len(content) - length + len(text), len(text)]
    start = b"glTF" + struct.pack("<III", 2, *head) + b"JSON"
    (tmp_path / "a.glb").write_bytes(start + text + content[20 + length :])
    with pytest.raises(InputError, match=r"compressed \(KHR_draco_mesh_compression\)"):
        read(tmp_path / "a.glb")
