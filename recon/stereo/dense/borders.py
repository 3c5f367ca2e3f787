"""Borders of surfaces, moved to the edges of the image.

Windows of the cost extend a near surface beyond its border. There the neighbours of the same colour
decide, by a weighted median (Ma et al., 2013).
"""

from typing import Any

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.kernels.simd import Floats, Integers, kernel_with_nan

Image = NDArray[np.uint8]
Levels = NDArray[np.int16]
Shares = NDArray[np.int32]

_RADIUS_PX = 3
_SIDE_PX = 2 * _RADIUS_PX + 1
_JUMP_PX = 1.5
"""Smallest range of disparities in a window that contains a border."""
_UNLIKE_LEVELS = 8.0
"""Mean difference of the colours at which the weight of a neighbour falls to 1 / e."""
_NEAR_PX = 4.0
"""Standard deviation of the weights by distance."""
_WHOLE = np.float32(1 << 20)
"""A weight of 1: sums of integers do not depend on their order."""


def at_image_edges(disparity_px: Floats, image: Image) -> Floats:
    """The disparities (H, W) with those near borders of surfaces replaced by a weighted median.

    Parameters
    ----------
    disparity_px : (H, W) float32
        NaN = unknown; stays unknown, and has no weight.
    image : (H, W) or (H, W, 3) uint8
    """
    beside = ((_RADIUS_PX, _RADIUS_PX), (_RADIUS_PX, _RADIUS_PX))
    colours = np.pad(image.reshape(*image.shape[:2], -1).astype(np.int16), (*beside, (0, 0)))
    wide = np.pad(disparity_px, beside, constant_values=np.nan)
    found = disparity_px.copy()
    v, u = np.nonzero(_border_mask(disparity_px))
    places = np.stack([v, u], axis=1)
    _take_medians(wide, colours, places, _weights(colours.shape[2]), found)
    return found


def _border_mask(disparity: Floats) -> NDArray[np.bool_]:
    """(H, W) known pixels whose windows contain more than one surface."""
    known = np.isfinite(disparity)
    window = np.ones((_SIDE_PX, _SIDE_PX), np.uint8)
    largest = cv2.dilate(np.where(known, disparity, np.float32(-np.inf)), window)
    least = cv2.erode(np.where(known, disparity, np.float32(np.inf)), window)
    mask: NDArray[np.bool_] = known & (largest > least + _JUMP_PX)
    return mask


def _weights(num_colours: int) -> tuple[Floats, Floats]:
    """Weights by the summed difference of the colours, and by place in the window."""
    unlike = np.arange(255 * num_colours + 1) / (_UNLIKE_LEVELS * num_colours)
    steps_sq = np.arange(-_RADIUS_PX, _RADIUS_PX + 1) ** 2
    near = np.exp(-(steps_sq[:, None] + steps_sq) / (2 * _NEAR_PX**2))
    return np.exp(-unlike).astype(np.float32), near.astype(np.float32)


@njit(cache=True, nogil=True, error_model="numpy")
def _take_medians(
    wide: Floats, colours: Levels, places: Integers, weights: tuple[Floats, Floats], found: Floats
) -> None:
    """Write the medians at some pixels (N, 2); images have margins of the window's radius."""
    values = np.empty(_SIDE_PX * _SIDE_PX, np.float32)
    shares = np.empty(_SIDE_PX * _SIDE_PX, np.int32)
    for k in range(len(places)):
        v, u = places[k, 0], places[k, 1]
        _weigh(wide, colours, (v, u), weights, (values, shares))
        found[v, u] = _weighted_median(values, shares, found[v, u])


@kernel_with_nan
def _weigh(
    wide: Floats,
    colours: Levels,
    place: tuple[int, int],
    weights: tuple[Floats, Floats],
    window: tuple[Floats, Shares],
) -> None:
    """Write the values of a pixel's window, and their weights; 0 for unknown ones."""
    v, u = place
    middle = colours[v + _RADIUS_PX, u + _RADIUS_PX]
    for at in range(_SIDE_PX * _SIDE_PX):
        row, column = at // _SIDE_PX, at % _SIDE_PX
        value, other = wide[v + row, u + column], colours[v + row, u + column]
        unlike = np.int64(0)
        for k in range(middle.size):
            unlike += abs(np.int64(middle[k]) - np.int64(other[k]))
        weight = _WHOLE * weights[0][unlike] * weights[1][row, column]
        window[0][at] = value
        window[1][at] = np.int32(weight) if np.isfinite(value) else 0


@kernel_with_nan
def _weighted_median(values: Floats, weights: Shares, start: Any) -> Any:
    """The least value up to which half of the weight is reached, by steps from one of the values.

    Most pixels are near it: fewer operations than sorting.
    """
    median, total = start, weights.sum()
    while True:
        below, up_to = np.int32(0), np.int32(0)
        lower, higher = np.float32(-np.inf), np.float32(np.inf)
        for k in range(values.size):
            below += weights[k] if values[k] < median else np.int32(0)
            up_to += weights[k] if values[k] <= median else np.int32(0)
            lower = max(lower, values[k]) if values[k] < median else lower
            higher = min(higher, values[k]) if values[k] > median else higher
        if 2 * below >= total:
            median = lower
        elif 2 * up_to < total:
            median = higher
        else:
            return median
