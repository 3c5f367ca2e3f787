"""Images and depth maps as files."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.files import atomic_path
from recon.sequences.pfm import write_pfm

_PER_UNIT = 1000.0
_HIGHEST = np.iinfo(np.uint16).max


def write_depth(folder: Path, name: str, depth: NDArray[np.floating]) -> None:
    """Write a depth (H, W), NaN = unknown, as NAME.pfm and as NAME.png.

    The image is in thousandths of a world unit (millimetres for metres); unknown depths or those
    beyond 65.535 units are 0 there.
    """
    folder.mkdir(exist_ok=True)
    write_pfm(folder / f"{name}.pfm", depth)
    steps = np.rint(np.nan_to_num(depth.astype(np.float64), nan=0.0) * _PER_UNIT)
    _write_png(folder / f"{name}.png", np.where(steps <= _HIGHEST, steps, 0).astype(np.uint16))


def write_image(path: Path, image: NDArray[np.uint8]) -> None:
    """Write an image (H, W) or (H, W, 3) RGB as PNG."""
    _write_png(path, image if image.ndim == 2 else image[..., ::-1])


def _write_png(path: Path, pixels: NDArray[np.generic]) -> None:
    with atomic_path(path) as part:
        part.write_bytes(cv2.imencode(".png", pixels)[1].tobytes())
