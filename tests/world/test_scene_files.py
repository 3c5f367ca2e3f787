"""A scene reads no file outside its own folder, unless that is allowed."""

import pytest
from PIL import Image

from recon.errors import InputError
from recon.files import outside_allowed
from recon.world.scene import read_scene, write_scene
from recon.world.visuals import (
    MeshVisual,
    Scene,
    Shader,
    SphereVisual,
)

WHITE = (1.0, 1.0, 1.0, 1.0)
PLAIN = Shader(ambient=WHITE, diffuse=WHITE, specular=WHITE, emissive=WHITE, shininess=1.0)


def outside_scene(tmp_path, texture):
    """Write a scene to its own folder, with a sphere that is textured by an image."""
    folder = tmp_path / "scene"
    folder.mkdir()
    sphere = SphereVisual(centre=(0, 0, 0), radius=1, shader=0, texture=0)
    write_scene(Scene(shaders=(PLAIN,), textures=(texture,), visuals=(sphere,)), folder / "a.scene")
    return folder / "a.scene"


@pytest.mark.parametrize("texture", ["../a.png", "{}/a.png", "linked.png", "../../nowhere.png"])
def test_texture_outside_the_scene_folder_needs_permission(tmp_path, texture):
    Image.new("RGB", (2, 2)).save(tmp_path / "a.png")
    scene = outside_scene(tmp_path, texture.format(tmp_path))
    (scene.parent / "linked.png").symlink_to(tmp_path / "a.png")
    with pytest.raises(InputError, match="outside the scene's folder; give --allow-outside"):
        read_scene(scene)
    with outside_allowed():
        if "nowhere" in texture:
            with pytest.raises(InputError, match="beside the scene or one"):
                read_scene(scene)
        else:
            assert read_scene(scene).textures == (texture.format(tmp_path),)


def test_impossible_file_name_is_rejected(tmp_path):
    with pytest.raises(InputError, match="beside the scene or one"):
        read_scene(outside_scene(tmp_path, "a\0b.png"))


def test_mesh_outside_the_scene_folder_is_rejected(tmp_path):
    (tmp_path / "a.ply").touch()
    (tmp_path / "in").mkdir()
    write_scene(
        Scene(
            shaders=(PLAIN,),
            textures=(),
            visuals=(MeshVisual(file="../a.ply", shader=0),),
        ),
        tmp_path / "in/a.scene",
    )
    with pytest.raises(InputError, match=r"'../a.ply', which lies outside"):
        read_scene(tmp_path / "in/a.scene")
