"""OpenCV's dense matchers: for comparison, and as the fast method of the dense stage."""

from collections.abc import Callable
from functools import partial
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.stereo.dense.cost import Search
from recon.stereo.kernels.simd import Floats
from recon.stereo.kernels.threads import run
from recon.stereo.matching.sgbm import BLOCK_PX, semi_global

Grey = NDArray[np.uint8]

_BM_BLOCK_PX = 15
_TOLERANCE_PX = 1
"""Maximum difference of the disparities of both images."""
_FIXED_POINT = 16.0
SIGMA_PX = np.float32(0.25)
"""Standard deviation of their correct disparities, measured on recorded pairs with truth."""


def three_ways(left: Grey, right: Grey, search: Search) -> Floats:
    """StereoSGBM along three directions, with a small cost volume."""
    return _sgbm(cv2.StereoSGBM_MODE_SGBM_3WAY)(left, right, search)


def confirmed_three_ways(left: Grey, right: Grey, search: Search) -> Floats:
    """The same, confirmed to a pixel by matching the right image separately.

    OpenCV's own check derives the right image's choice from the left one's costs, and keeps more
    wrong disparities.
    """
    turned = np.ascontiguousarray(right[:, ::-1]), np.ascontiguousarray(left[:, ::-1])
    tasks = [partial(three_ways, a, b, search) for a, b in ((left, right), turned)]
    ours, theirs = run(tasks)
    columns = np.arange(left.shape[1]) - np.rint(np.nan_to_num(ours)).astype(np.intp)
    columns = columns.clip(0, left.shape[1] - 1)
    back = np.take_along_axis(theirs[:, ::-1], columns, axis=1)
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(back - ours) <= _TOLERANCE_PX, ours, np.float32(np.nan))


def _sgbm(mode: int) -> Callable[[Grey, Grey, Search], Floats]:
    def match(left: Grey, right: Grey, search: Search) -> Floats:
        matcher = semi_global(search.first, search.depth, mode)
        return _matched(matcher, (left, right), search, BLOCK_PX)

    return match


def _bm(left: Grey, right: Grey, search: Search) -> Floats:
    matcher = cv2.StereoBM.create(numDisparities=search.depth, blockSize=_BM_BLOCK_PX)
    matcher.setMinDisparity(search.first)
    return _matched(matcher, (left, right), search, _BM_BLOCK_PX)


def _matched(matcher: Any, images: tuple[Grey, Grey], search: Search, block_px: int) -> Floats:
    """(H, W) disparity, NaN = unknown; margins let the matcher use all columns and rows."""
    before = max(search.first + search.depth, 0) + block_px
    behind = max(-search.first, 0) + block_px
    pad = ((block_px, block_px), (before, behind))
    fixed = matcher.compute(*(np.pad(image, pad, mode="edge") for image in images))
    fixed = fixed[block_px:-block_px, before:-behind]
    disparity = fixed.astype(np.float32) / np.float32(_FIXED_POINT)
    outside = (disparity < search.first) | (disparity > search.first + search.size - 1)
    return np.where(outside, np.float32(np.nan), disparity)


PEERS: dict[str, Callable[[Grey, Grey, Search], Floats]] = {
    "hh": _sgbm(cv2.StereoSGBM_MODE_HH),
    "sgbm": _sgbm(cv2.StereoSGBM_MODE_SGBM),
    "bm": _bm,
}
"""The matchers for comparison, by name."""
