"""Feature points of one image, and the matched pairs of two images."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_shape
from recon.records.noise import ImageNoise


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Features:
    """Oriented feature points, and the filter responses of their image."""

    points_px: NDArray[np.float64]
    """(N, 2) u, v; in row order."""
    orientation_rad: NDArray[np.float32]
    """(N,) direction of the edge normal, in [0, pi)."""
    modulus: NDArray[np.float32]
    """(N,) strength of the response over all scales."""
    grey: NDArray[np.uint8]
    """(H, W) brightness of the image."""
    widths_px: tuple[float, ...]
    """(S,) widths of the filters."""
    planes: NDArray[np.float32]
    """(H, S, O, 2, W') real and imaginary response of each pixel at S scales and O orientations;
    rows are padded to W' >= W columns; the padding is meaningless."""
    candidate_mask: NDArray[np.bool_]
    """(H, W) pixels strong enough to be matched with, or to support a match."""
    noise: ImageNoise
    """Noise of the image."""

    def __len__(self) -> int:
        return len(self.points_px)

    def __repr__(self) -> str:
        height, width = self.grey.shape
        return f"Features({len(self)} points of an image of {width} x {height} pixels)"


def check_alike(left: Features, right: Features) -> None:
    """Raise `InputError` if the image sizes or the filters differ."""
    if left.grey.shape != right.grey.shape:
        raise InputError(
            f"left image has shape {left.grey.shape}, right {right.grey.shape}, but one is needed"
        )
    if left.widths_px != right.widths_px:
        raise InputError(
            f"left features have filters {left.widths_px} px wide, right {right.widths_px}, "
            "but the same are needed"
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Matches:
    """Pairs of one left and one right feature, most confident first; no left point twice."""

    points_px: NDArray[np.float64]
    """(M, 2) u, v in the left image."""
    disparity_px: NDArray[np.float64]
    """(M,) u_left - u_right."""
    sigma_px: NDArray[np.float64]
    """(M,) standard deviation of the disparity; NaN before sub-pixel refinement."""
    score: NDArray[np.float64]
    """(M,) confidence, descending."""
    index_left: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))
    """(M,) row of the left feature that the pair started from; -1 if none."""
    index_right: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))
    """(M,) row of the right feature at the matched pixel; -1 if that is only a candidate."""
    probability: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    """(M,) probability that the disparity is correct to a pixel; NaN if unknown."""
    is_whole: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    """(M,) after sub-pixel refinement, disparities that are known only to the pixel."""

    def __post_init__(self) -> None:
        check_shape("points_px", self.points_px, (None, 2))
        unknown_of = {"index_left": -1, "index_right": -1, "probability": np.nan, "is_whole": False}
        for name, unknown in unknown_of.items():
            column = getattr(self, name)
            if len(self) and not len(column):
                object.__setattr__(self, name, np.full(len(self), unknown, column.dtype))
        for name in Matches.__slots__[1:]:
            check_shape(name, getattr(self, name), (len(self),))

    def __len__(self) -> int:
        return len(self.points_px)

    def __repr__(self) -> str:
        low, high = (f"{f(self.disparity_px):.1f}" for f in (np.min, np.max)) if len(self) else "--"
        return f"Matches({len(self)} pairs, disparities {low} to {high} px)"

    @classmethod
    def none(cls) -> "Matches":
        """An empty set of matches."""
        number, index = np.zeros(0), np.zeros(0, np.int32)
        return cls(
            points_px=np.zeros((0, 2)), disparity_px=number, sigma_px=number, score=number,
            index_left=index, index_right=index,
        )  # fmt: skip

    def select(self, rows: NDArray[np.integer] | NDArray[np.bool_] | slice) -> "Matches":
        """The matches of `rows`, in that order."""
        return Matches(**{name: getattr(self, name)[rows] for name in Matches.__slots__})

    def probable(self) -> "Matches":
        """The matches that are not more likely wrong than correct."""
        # Written so that an unknown probability passes.
        return self.select(~(self.probability < 0.5))
