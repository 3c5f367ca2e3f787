"""Textures: shipped, looked up beside the scene, and laid out with mipmaps."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from recon.errors import InputError
from recon.world.textures import SHIPPED, build_atlas, find_texture, read_texture

NAMES = (
    "checker", "wood", "brick", "grass", "roof", "sky", "earth", "cobra", "bubinga", "leaves",
    "marble",
)  # fmt: skip
TOOL = Path(__file__).parents[2] / "tools" / "make_textures.py"


def save(path, colour):
    path.parent.mkdir(exist_ok=True)
    Image.new("RGB", (4, 4), colour).save(path)


@pytest.mark.parametrize("name", NAMES)
def test_every_documented_texture_is_shipped(name, tmp_path):
    image = read_texture(f"textures/{name}.tga", tmp_path)
    assert image.shape == (256, 256, 3)
    assert image.dtype == np.uint8
    # Richly textured: most of the contrast has wavelengths of 4 to 40 texels.
    grey = image.mean(axis=2)
    power = np.abs(np.fft.fft2(grey - grey.mean())) ** 2
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(256), np.fft.fftfreq(256)))
    band = (frequency > 1 / 40) & (frequency < 1 / 4)
    assert grey.std() > 10
    assert power[band].sum() / power.sum() > (0.3 if name == "sky" else 0.5)


def test_tool_reproduces_the_shipped_textures():
    made = runpy.run_path(str(TOOL))
    number = [maker.__name__ for maker in made["MAKERS"]].index("wood")
    image = made["wood"](np.random.default_rng(number))
    np.testing.assert_allclose(image, read_texture("wood", None), atol=2.01)


def test_hues_of_textures_are_distinguishable():
    def hue(name):
        rgb = read_texture(name, None)
        hsv = np.asarray(Image.fromarray(rgb).convert("HSV"), float)
        return np.median(hsv[..., 0]) * 360 / 255

    hues = {name: hue(name) for name in ("wood", "grass", "leaves", "brick", "roof")}
    for crown in ("grass", "leaves"):
        assert abs(hues[crown] - hues["wood"]) > 40
    assert abs(hues["wood"] - hues["brick"]) > 15
    assert 90 < abs(hues["roof"] - hues["brick"]) < 270


def test_texture_beside_the_scene_takes_precedence_whatever_its_extension(tmp_path):
    assert find_texture("textures/wood.tga", tmp_path) == SHIPPED / "wood.png"
    save(tmp_path / "textures" / "wood.png", (1, 2, 3))
    assert find_texture("textures/wood.tga", tmp_path) == tmp_path / "textures" / "wood.png"
    save(tmp_path / "textures" / "wood.tga", (4, 5, 6))
    assert read_texture("textures/wood.tga", tmp_path)[0, 0].tolist() == [4, 5, 6]
    assert find_texture("textures/paper.tga", tmp_path) is None


def test_invalid_image_is_rejected(tmp_path):
    (tmp_path / "wood.png").write_text("no image")
    with pytest.raises(InputError, match=r"wood\.png: .*but an image is needed for the texture"):
        read_texture("wood.png", tmp_path)
    with pytest.raises(InputError, match="texture is 'paper', but one beside the scene"):
        read_texture("paper", tmp_path)


def test_atlas_holds_every_mipmap_level():
    image = np.arange(6 * 3 * 3, dtype=np.uint8).reshape(6, 3, 3)
    atlas = build_atlas([image, image[:1, :1]], mipmaps=True)
    assert atlas.shape[0].tolist() == [[6, 3], [3, 1], [1, 1]]
    assert atlas.shape[1].tolist() == [[1, 1]] * 3
    first = atlas.texels[atlas.start[0, 0] :][:18].reshape(6, 3, 3)
    np.testing.assert_array_equal(first, image)
    np.testing.assert_allclose(atlas.texels[atlas.start[0, 2]], image.mean(axis=(0, 1)), atol=2)
    assert build_atlas([image], mipmaps=False).start.shape == (1, 1)
