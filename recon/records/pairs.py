"""Views, and the pairs of images taken from them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.errors import InputError, as_numbers, check_number, check_shape, check_type
from recon.geometry import check_rigid

Image = NDArray[np.uint8]
"""(H, W, 3) RGB or (H, W) grey."""


def as_rgb(image: Image) -> Image:
    """An image (H, W, 3); a grey one has its level in every channel."""
    return image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class View:
    """A camera position and a target point, in the world.

    The camera parameters that are None stay as they are. Field of view and focal length determine
    each other through the sensor width, so at most one may be given.
    """

    position: NDArray[np.float64]
    """(3,) the point midway between the cameras."""
    target: NDArray[np.float64]
    """(3,) the point both cameras look at."""
    focal_length: float | None = None
    """World units."""
    fov_deg: float | None = None
    baseline: float | None = None
    """World units."""
    near: float | None = None
    far: float | None = None

    def __post_init__(self) -> None:
        for name in ("position", "target"):
            point = as_numbers(name, getattr(self, name))
            check_shape(name, point, (3,))
            object.__setattr__(self, name, point)
        for name in ("focal_length", "fov_deg", "baseline", "near", "far"):
            if getattr(self, name) is not None:
                check_number(name, getattr(self, name))
        if self.focal_length is not None and self.fov_deg is not None:
            raise InputError(
                f"focal_length is {self.focal_length} and fov_deg is {self.fov_deg}, "
                "but one follows from the other: give one of them"
            )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StereoPair:
    """Two rectified images taken at the same time."""

    left: NDArray[np.uint8]
    """(H, W, 3) RGB or (H, W) grey."""
    right: NDArray[np.uint8]
    """The same shape as `left`."""
    rig: StereoRig
    T_world_left: NDArray[np.float64] | None = None
    """(4, 4) pose of the left camera, None if unknown."""
    stamp_s: float = 0.0
    name: str = "pair"
    """A file or a number, for messages."""
    disparity_range: tuple[int, int] | None = None
    """(min, max) in pixels, both included, if the recording states it."""

    def __post_init__(self) -> None:
        check_images(self.left, self.right, self.name)
        check_type("rig", self.rig, StereoRig)
        check_number("stamp_s", self.stamp_s)
        if self.left.shape[:2] != (self.rig.height, self.rig.width):
            raise InputError(
                f"{self.name} is {self.left.shape[1]} x {self.left.shape[0]} pixels, but its "
                f"calibration is for {self.rig.width} x {self.rig.height}"
            )
        if self.T_world_left is not None:
            check_rigid("T_world_left", self.T_world_left)

    def __repr__(self) -> str:
        height, width = self.left.shape[:2]
        kind = "grey" if self.left.ndim == 2 else "RGB"
        posed = "posed" if self.T_world_left is not None else "without a pose"
        return f"StereoPair({self.name}: {width} x {height} {kind}, {posed}, {self.stamp_s:g} s)"


def check_images(left: NDArray[np.uint8], right: NDArray[np.uint8], name: str = "pair") -> None:
    """Raise `InputError` unless both are uint8 images, grey or RGB, of one size."""
    for side, image in (("left", left), ("right", right)):
        if not isinstance(image, np.ndarray):
            raise InputError(
                f"{name}: {side} image is of type {type(image).__name__}, but an array is needed"
            )
        if image.dtype != np.uint8:
            raise InputError(f"{name}: {side} image is {image.dtype}, but uint8 is needed")
        if image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] != 3) or not image.size:
            raise InputError(
                f"{name}: {side} image has shape {image.shape}, but (H, W) or (H, W, 3) is needed"
            )
    if left.shape != right.shape:
        raise InputError(
            f"{name}: left image has shape {left.shape}, right {right.shape}, but one is needed"
        )


class PairSource(Protocol):
    """A sequence of pairs, read one at a time."""

    disparity_range: tuple[int, int] | None
    """(min, max) in pixels, both included, if the recording states it; else None."""

    @property
    def skipped(self) -> Sequence[tuple[str, str]]:
        """Names of the pairs skipped so far, with the reasons."""
        ...

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[StereoPair]: ...

    def __getitem__(self, part: slice, /) -> "PairSource": ...
