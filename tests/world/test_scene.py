"""Geometry files: read as they are, written without loss, faults named by file and line."""

import dataclasses
import math
import re

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings

from recon.errors import InputError
from recon.world.scene import read_scene, write_scene
from recon.world.visuals import (
    CylinderVisual,
    EllipsoidVisual,
    MeshVisual,
    PolygonVisual,
    Scene,
    Shader,
    SphereVisual,
    Vertex,
)

from .conftest import SCENES

SMALL = """\
# Shader count
1
# Texture count
2
# Visual count
2
# SHADER 0
# Ambient color
1.0 1.0 1.0 1.0
# Diffuse color
1.0 0.0 0.0 0.0
# Specular color
1.0 0.0 1.0 0.0
# Emissive color
0.0 0.0 0.0 0.0
# Shininess [0,128]
50
textures/wood.tga
textures/nowhere.tga
# VISUAL 0 - TREE TOP
# Visual type
SPHERE
# Center
10 12 20
# Radius
4
# Shader index
-1
# Texture index
0
# VISUAL 1 - TREE BODY
# Visual type
CYLINDER
# RadiusBase
2
# RadiusTop
2
# Height
8
# Slices
50
# Stacks
30
# Translation [x,y,z]
10 8 20
# Rotation [x,y,z]
1 0 0
# Shader index
0
# Texture index
-1
"""


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "small.scene"
        path.write_text(text)
        return path

    return write


def test_scene_of_appendix_b_is_read_unchanged():
    scene = read_scene(SCENES / "village.scene")
    assert [len(part) for part in (scene.shaders, scene.textures, scene.visuals)] == [3, 9, 13]
    assert scene.shaders[1].diffuse == (0.0, 0.0, 1.0, 0.0)
    assert scene.textures[3] == "textures/grass.tga"
    assert scene.visuals[0] == SphereVisual(centre=(10, 12, 20), radius=4, texture=3)
    assert scene.visuals[3] == CylinderVisual(
        radius_base=1, radius_top=7, height=4, slices=36, stacks=50, translation=(20, 11, -5),
        texture=4,
    )  # fmt: skip
    ground = scene.visuals[12]
    assert ground.cull_back
    assert ground.shader == 1
    assert ground.vertices[2].position == (500, 0, 500)
    assert ground.vertices[2].uv == (3, 3)


@pytest.mark.parametrize("name", ["village", "three_kinds", "three_apples", "square"])
def test_scene_is_written_without_loss(name, tmp_path):
    scene = read_scene(SCENES / f"{name}.scene")
    write_scene(scene, tmp_path / "again.scene")
    again = read_scene(tmp_path / "again.scene")
    assert dataclasses.replace(again, folder=scene.folder) == scene


reals = st.floats(-1e6, 1e6)
sizes = st.floats(1e-6, 1e6)
vectors = st.tuples(reals, reals, reals)
colours = st.tuples(reals, reals, reals, reals)
shader = st.integers(-1, 0)
texture = st.sampled_from([-1, 1])
vertices = st.builds(Vertex, position=vectors, colour=colours, uv=st.tuples(reals, reals))
visuals = st.one_of(
    st.builds(SphereVisual, centre=vectors, radius=sizes, shader=shader, texture=texture),
    st.builds(
        EllipsoidVisual,
        centre=vectors,
        radii=st.tuples(sizes, sizes, sizes),
        shader=shader,
        texture=texture,
    ),
    st.builds(
        CylinderVisual,
        radius_base=st.just(0.0) | sizes,
        radius_top=sizes,
        height=sizes,
        slices=st.integers(3, 500),
        stacks=st.integers(1, 500),
        translation=vectors,
        rotation=vectors,
        shader=shader,
        texture=texture,
    ),
    st.builds(
        PolygonVisual,
        cull_back=st.booleans(),
        vertices=st.lists(vertices, min_size=3, max_size=5).map(tuple),
        shader=shader,
        texture=texture,
    ),
    st.builds(MeshVisual, file=st.just("tetra hedron.ply"), shader=shader, texture=texture),
)


@settings(max_examples=60)
@given(visuals=st.lists(visuals, max_size=4).map(tuple), ambient=colours)
def test_any_scene_round_trips_through_its_file(visuals, ambient, tmp_path_factory):
    folder = tmp_path_factory.getbasetemp()
    (folder / "tetra hedron.ply").touch()
    material = Shader(
        ambient=ambient, diffuse=ambient, specular=ambient, emissive=ambient, shininess=128.0
    )
    scene = Scene(
        shaders=(material,), textures=("nowhere.tga", "a/wood.tga"), visuals=visuals, folder=folder
    )
    write_scene(scene, folder / "any.scene")
    assert read_scene(folder / "any.scene") == scene


def test_text_of_comments_is_ignored(written):
    rows = ["# whatever" if row.startswith("#") else row for row in SMALL.splitlines()]
    free = read_scene(written("\n\n".join(rows)))
    assert free == read_scene(written(SMALL))


def test_comments_may_use_the_name_of_another_field(written):
    text = SMALL.replace("# RadiusBase", "# Radius").replace("# Translation", "# Center")
    assert read_scene(written(text)) == read_scene(written(SMALL))


def test_windows_files_are_read(written, tmp_path):
    path = tmp_path / "windows.scene"
    path.write_bytes(b"\xef\xbb\xbf# \xdeekil\r\n" + SMALL.replace("\n", "\r\n").encode())
    assert read_scene(path) == read_scene(written(SMALL))


def test_unused_texture_is_not_looked_up(written):
    assert read_scene(written(SMALL)).textures[1] == "textures/nowhere.tga"


@pytest.mark.parametrize(
    ("old", "new", "row", "message"),
    [
        ("\n4\n", "\n-4\n", "-4", "visual 0 (SPHERE) Radius is '-4', but a number above 0"),
        ("\n4\n", "\nnan\n", "nan", "Radius is 'nan', but a number above 0, up to 1e9"),
        ("10 12 20", "10 inf 20", "10 inf 20", "Center is '10 inf 20', but a line of three"),
        ("10 12 20", "10820", "10820", "Center is '10820', but a line of three"),
        ("\n50\n# Stacks", "\n2.5\n# Stacks", "2.5", "Slices is '2.5', but a whole number from 3"),
        ("SPHERE", "CUBE", "CUBE", "visual 0 type is 'CUBE', but one of SPHERE, ELLIPSOID, CYL"),
        ("# Radius\n4\n", "", "-1", "Radius is missing: the value is one of 'shader index'"),
        ("# Radius\n4\n", "# Radius\n", "-1", "Radius is missing: the value is one of"),
        ("index\n0\n# VISUAL", "index\n1\n# VISUAL", "1", "texture 'textures/nowhere.tga', but a"),
        ("index\n0\n# VISUAL", "index\n7\n# VISUAL", "7", "texture index is '7', but a whole num"),
        ("index\n0\n# Tex", "index\n9\n# Tex", "9", "shader index is '9', but a whole number fro"),
        ("count\n1\n", "count\n-1\n", "-1", "shader count is '-1', but a whole number from 0"),
        ("count\n1\n", "count\n2\n", "textures/wood.tga", "shader 1 Ambient color is 'textures/w"),
        (
            "Texture count\n2",
            "Texture count\n3",
            "SPHERE",
            "texture 2 is missing: the value is one of 'vi",
        ),
        ("Texture count\n2", "Texture count\n1", "textures/nowhere.tga", "visual 0 type is 'text"),
        ("Visual count\n2", "Visual count\n1", "CYLINDER", "visual count is 1, but 'CYLINDER' fo"),
        ("# RadiusBase\n2\n# RadiusTop\n2", "#\n0\n#\n0", None, "has radius 0 at both ends, but"),
    ],
)
def test_error_names_file_and_line_in_one_line(written, old, new, row, message):
    text = SMALL.replace(old, new, 1)
    assert text != SMALL
    path = written(text)
    with pytest.raises(InputError) as caught:
        read_scene(path)
    told = str(caught.value)
    assert message in told
    assert "\n" not in told
    number = int(told.removeprefix(f"{path}:").partition(":")[0])
    if row is not None:
        assert text.splitlines()[number - 1] == row


def test_truncated_file_is_rejected_in_one_line(written):
    rows = SMALL.splitlines()
    for count in range(len(rows)):
        path = written("\n".join(rows[:count]))
        with pytest.raises(InputError, match=r"small\.scene:\d+: .*(needed|both ends)"):
            read_scene(path)


words = st.sampled_from(
    ["", "#", "1", "-1", "1e400", "0 0", "SPHERE", "POLYGON", "MESH", "nan", "é"]
)


@settings(max_examples=150)
@given(data=st.data())
def test_damaged_file_is_read_or_rejected_in_one_line(data, tmp_path_factory):
    rows = SMALL.splitlines()
    for _ in range(data.draw(st.integers(1, 3))):
        rows[data.draw(st.integers(0, len(rows) - 1))] = data.draw(words)
    path = tmp_path_factory.getbasetemp() / "damaged.scene"
    path.write_text("\n".join(rows))
    fault = fault_of(path)
    assert fault is None or re.fullmatch(rf"{re.escape(str(path))}:\d+: .+(needed|last one)", fault)


def fault_of(path):
    try:
        read_scene(path)
    except InputError as error:
        return str(error)
    return None


def test_missing_mesh_file_is_named(written):
    text = SMALL.replace("SPHERE\n# Center\n10 12 20\n# Radius\n4", "MESH\n# File\nrock.ply")
    with pytest.raises(InputError, match=r":\d+: visual 0 \(MESH\) File is 'rock.ply', but a file"):
        read_scene(written(text))


def test_binary_file_is_rejected(tmp_path):
    path = tmp_path / "image.scene"
    path.write_bytes(bytes(range(128, 256)))
    with pytest.raises(InputError, match=r"image\.scene:1: shader count is .*, but a whole number"):
        read_scene(path)


def test_numbers_round_trip_exactly(tmp_path):
    scene = Scene(visuals=(SphereVisual(centre=(0.1, -0.0, math.pi), radius=1e9),))
    write_scene(scene, tmp_path / "a.scene")
    assert read_scene(tmp_path / "a.scene").visuals == scene.visuals


def test_too_high_texture_count_is_found_without_comments(written):
    rows = [row for row in SMALL.splitlines() if not row.startswith("#")]
    path = written("\n".join(rows).replace("1\n2\n2", "1\n3\n2", 1))
    with pytest.raises(InputError, match="texture 2 is 'SPHERE', but the name of an image is"):
        read_scene(path)
