"""Gain of the right camera relative to the left one, from the contrasts of their rows."""

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.kernels.sorting import median

Grey = NDArray[np.uint8]
Array = NDArray[np.float64]

_BAND_ROWS = 16
"""Rows per band: both cameras see nearly the same in a band."""
_ROW_STEP = 4
_REACH_PX = 4
"""Distance over which levels are compared: there, edges outweigh noise."""
_NUM_ERRORS = 3.0
"""Standard errors above which a gain is significant, not due to different views."""
_SHARE_AGREEING = 0.8
"""Share of bands that have to agree: occlusions do not affect all bands."""
_LEAST_RATIO, _LARGEST_RATIO = 1.05, 2.0
"""A smaller gain is harmless, a larger one implausible."""


def gain_between(left: Grey, right: Grey) -> float:
    """Contrast of the right image relative to the left one; exactly 1 if insignificant.

    The median of the contrast ratios of bands of rows. An offset affects neither the contrasts nor
    the phases, which are invariant to the mean.

    Parameters
    ----------
    left, right : (H, W) uint8
    """
    ours, theirs = _contrasts(left), _contrasts(right)
    usable = (ours > 0) & (theirs > 0)
    ratios = np.log(theirs[usable] / ours[usable])
    if len(ratios) < 2:
        return 1.0
    middle = median(ratios)
    spread = 1.4826 * median(np.abs(ratios - middle))
    error = 1.25 * spread / np.sqrt(len(ratios))
    agreeing = np.count_nonzero(ratios * middle > 0) / len(ratios)
    surely = max(float(np.log(_LEAST_RATIO)), _NUM_ERRORS * error)
    if agreeing < _SHARE_AGREEING or not surely < abs(middle) < np.log(_LARGEST_RATIO):
        return 1.0
    return float(np.exp(middle))


def with_gain_of(left: Grey, right: Grey) -> Grey:
    """The right image (H, W) with contrast and mean of the left one, if their gains differ."""
    gain = gain_between(left, right)
    if gain == 1.0:
        return right
    levels = (np.arange(256) - right.mean()) / gain + left.mean()
    brought: Grey = cv2.LUT(right, np.rint(levels).clip(0, 255).astype(np.uint8))
    return brought


@njit(cache=True, nogil=True, fastmath=True)
def _contrasts(grey: Grey) -> Array:
    """(B,) root mean square difference along the row, of each band."""
    height, width = grey.shape
    num = -(-height // _BAND_ROWS)
    energy, count = np.zeros(num), np.zeros(num)
    for v in range(0, height, _ROW_STEP):
        row, total = grey[v], np.float32(0)
        for u in range(width - _REACH_PX):
            step = np.float32(row[u + _REACH_PX]) - np.float32(row[u])
            total += step * step
        energy[v // _BAND_ROWS] += total
        count[v // _BAND_ROWS] += max(width - _REACH_PX, 1)
    return np.sqrt(energy / count)
