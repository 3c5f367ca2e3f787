"""Texture images, looked up by name and laid out with their mipmaps for sampling."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from recon.errors import InputError
from recon.world.visuals import MeshVisual, Scene

SHIPPED = Path(__file__).parent / "shipped"
"""recon's own images, created by tools/make_textures.py."""

_ENDINGS = (".tga", ".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".ppm")


def find_texture(name: str, folder: Path | None) -> Path | None:
    """The image that a scene in `folder` calls `name`: beside the scene first, then recon's own.

    The suffix is ignored: "textures/wood.tga" may be wood.png.
    """
    if folder is not None:
        exact = folder / name
        beside = (exact, *(exact.with_suffix(ending) for ending in _ENDINGS))
        found = next((path for path in beside if path.is_file()), None)
        if found:
            return found
    shipped = SHIPPED / f"{Path(name).stem}.png"
    return shipped if shipped.is_file() else None


def scene_files(scene: Scene) -> tuple[Path, ...]:
    """The further files of a scene: meshes, and textures of its visuals."""
    names = {name for visual in scene.visuals if (name := scene.texture_of(visual))}
    textures = {find_texture(name, scene.folder) for name in names}
    meshes = {
        (scene.folder or Path()) / visual.file
        for visual in scene.visuals
        if isinstance(visual, MeshVisual)
    }
    return tuple(sorted(path for path in textures | meshes if path is not None))


def read_texture(name: str, folder: Path | None) -> NDArray[np.uint8]:
    """Pixels (H, W, 3) RGB of a texture.

    Raises
    ------
    InputError
        If it is missing or not an image.
    """
    path = find_texture(name, folder)
    if path is None:
        raise InputError(f"texture is {name!r}, but one beside the scene or of recon's is needed")
    try:
        with Image.open(path) as image:
            return np.asarray(image.convert("RGB"), dtype=np.uint8)
    except (OSError, ValueError, Image.DecompressionBombError) as error:
        raise InputError(f"{path}: {error}, but an image is needed for the texture") from error


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TextureAtlas:
    """Textures and their mipmap levels in one array, for the compiled loop."""

    texels: NDArray[np.uint8]
    """(T, 3) RGB, row by row, level by level."""
    start: NDArray[np.int64]
    """(N, L) first texel of a texture's level; the last level is repeated."""
    shape: NDArray[np.int64]
    """(N, L, 2) height and width of the levels."""


def build_atlas(images: Sequence[NDArray[np.uint8]], mipmaps: bool) -> TextureAtlas:
    """Lay out images (H, W, 3); without mipmaps each has only its own size."""
    pyramids = [_pyramid(image) if mipmaps else [image] for image in images]
    num_levels = max((len(pyramid) for pyramid in pyramids), default=1)
    texels, start, shape, total = [np.zeros((1, 3), np.uint8)], [], [], 1
    for pyramid in pyramids:
        offsets = []
        for level in pyramid:
            texels.append(level.reshape(-1, 3))
            offsets.append(total)
            total += level.shape[0] * level.shape[1]
        missing = num_levels - len(pyramid)
        start.append(offsets + offsets[-1:] * missing)
        shape.append([level.shape[:2] for level in pyramid] + [pyramid[-1].shape[:2]] * missing)
    return TextureAtlas(
        texels=np.concatenate(texels),
        start=np.array(start, np.int64).reshape(-1, num_levels),
        shape=np.array(shape, np.int64).reshape(-1, num_levels, 2),
    )


def _pyramid(image: NDArray[np.uint8]) -> list[Any]:
    levels = [image]
    while max(levels[-1].shape[:2]) > 1:
        height, width = (max(1, size // 2) for size in levels[-1].shape[:2])
        smaller = cv2.resize(levels[-1], (width, height), interpolation=cv2.INTER_AREA)
        levels.append(smaller.reshape(height, width, 3))
    return levels
