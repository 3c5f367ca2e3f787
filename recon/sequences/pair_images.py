"""The two images of a pair, both in colour or both in grey."""

from pathlib import Path

import cv2

from recon.notices import notify
from recon.sequences.depth import Image, stretch_of
from recon.sequences.images import read_pixels


def read_pair(left_path: Path, right_path: Path) -> tuple[Image, Image]:
    """Two images, both in colour or both in grey, with the same stretch if they have 16 bits.

    Raises
    ------
    InputError
        If one is missing, truncated, damaged or not an image.
    """
    left, right = read_pixels(left_path), read_pixels(right_path)
    stretch = stretch_of([left, right])
    return alike(stretch(left), stretch(right))


def alike(left: Image, right: Image) -> tuple[Image, Image]:
    """Both images in grey if one of them is."""
    if left.ndim == right.ndim:
        return left, right
    notify("colour-missing", "one camera is grey and one in colour: both are used as grey")
    return grey(left), grey(right)


def grey(image: Image) -> Image:
    """An image (H, W) or (H, W, 3) RGB as grey."""
    one: Image = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    return one
