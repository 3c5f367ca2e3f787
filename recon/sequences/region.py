"""Cropping of the images."""

from collections.abc import Iterator
from dataclasses import replace

from recon.errors import InputError
from recon.records import PairSource, StereoPair
from recon.sequences.frames import DerivedSource

Region = tuple[int, int, int, int]
"""x, y, width, height in pixels."""


class RegionSource(DerivedSource):
    """The same region of every pair."""

    def __init__(self, source: PairSource, region: Region) -> None:
        super().__init__(source)
        self._region = region

    def __iter__(self) -> Iterator[StereoPair]:
        for pair in self.source:
            yield cut(pair, self._region)


def cut(pair: StereoPair, region: Region) -> StereoPair:
    """The region of both images; disparities and the poses stay as they are.

    Content left of the region in the right image is lost: near objects at the left border have no
    partner.

    Raises
    ------
    InputError
        If the region is empty or goes beyond the images.
    """
    x, y, width, height = region
    rig = pair.rig
    if min(x, y) < 0 or min(width, height) < 1 or x + width > rig.width or y + height > rig.height:
        raise InputError(
            f"roi is {x},{y},{width},{height}, but a part of {rig.width} x {rig.height} pixels "
            "is needed"
        )
    rows, columns = slice(y, y + height), slice(x, x + width)
    shifted = replace(
        rig,
        width=width,
        height=height,
        cx_left_px=rig.cx_left_px - x,
        cx_right_px=rig.cx_right_px - x,
        cy_px=rig.cy_px - y,
    )
    left, right = pair.left[rows, columns], pair.right[rows, columns]
    return replace(pair, left=left, right=right, rig=shifted)
