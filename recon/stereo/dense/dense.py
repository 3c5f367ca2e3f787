"""A disparity and its uncertainty for every pixel of a pair (the thesis's future work, chapter 5).

All pixels are matched by one semi-global cost and confirmed by the right image; borders of surfaces
are moved to edges of the image, planes through similar neighbours smooth each surface, and narrow
holes are filled with the surface behind. The fast method leaves borders where they are.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import DisparityMap, Matches, check_images
from recon.settings import QUALITIES, Quality, Settings, updated, with_quality
from recon.settings.stereo import DenseSettings, MatchingSettings
from recon.stereo.dense import uncertainty
from recon.stereo.dense.borders import at_image_edges
from recon.stereo.dense.choice import Choice, choose
from recon.stereo.dense.cost import UNIT, Search, cost_volume
from recon.stereo.dense.holes import filled_behind, without_specks
from recon.stereo.dense.paths import Penalties, aggregate
from recon.stereo.dense.peers import confirmed_three_ways
from recon.stereo.dense.surfaces import median, smooth
from recon.stereo.exposure import with_gain_of
from recon.stereo.features import to_grey
from recon.stereo.kernels.simd import Floats

Image = NDArray[np.uint8]
Grey = NDArray[np.uint8]

_EDGE_LEVELS = 12.0
"""Decay of the cost of a disparity jump with the grey-level difference."""
_SMALL_STEP, _LARGEST_STEP = 35.0, 100.0
"""Cost of a step of a pixel, and of a jump without a visible edge, in grey levels."""
_LARGE_STEP = _SMALL_STEP + (_LARGEST_STEP - _SMALL_STEP) * np.exp(-np.arange(256) / _EDGE_LEVELS)
PENALTIES = Penalties(
    small_step=round(UNIT * _SMALL_STEP), large_step=np.rint(UNIT * _LARGE_STEP).astype(np.int16)
)

_STRIP_BYTES = 700 << 20
"""Memory limit of the costs of a strip and their sums."""
_STRIP_MARGIN = 32
"""Rows above and below a strip where its paths start."""


def match_dense(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    min_disparity: int = 0,
    max_disparity: int = 20,
    quality: Quality = "best",
) -> DisparityMap:
    """Disparity of every pixel of two rectified images.

    Parameters
    ----------
    left, right : (H, W) or (H, W, 3) uint8
        Grey or RGB, of the same size.
    min_disparity, max_disparity : int
        Both ends of the search range, included.
    quality : {"best", "fast"}
        `fast` uses OpenCV's StereoSGBM (MODE_SGBM_3WAY) for the matching itself, from both sides;
        confirmation, smoothing, filling and sigma are recon's.

    Returns
    -------
    DisparityMap
    """
    if quality not in QUALITIES:
        raise InputError(f"quality is {quality!r}, but one of {', '.join(QUALITIES)} is needed")
    search = {"min_disparity": min_disparity, "max_disparity": max_disparity}
    settings = updated(with_quality(Settings(), quality), {"matching": search})
    return match_every_pixel(left, right, settings)


def match_every_pixel(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    settings: Settings,
    stated_range: tuple[int, int] | None = None,
) -> DisparityMap:
    """Disparity of every pixel of two rectified images, as the settings say.

    Parameters
    ----------
    stated_range : (min, max), optional
        Search range in pixels, used if the settings do not define one.

    Raises
    ------
    InputError
        If the images differ in size, or the search range lies outside them.
    """
    check_images(left, right)
    other = with_gain_of(to_grey(left), to_grey(right))
    search = _search(settings.matching.searching(stated_range), left.shape[1])
    found = _METHODS[settings.dense.method](left, other, search, settings.dense)
    disparity = filled_behind(found.disparity_px, settings.dense.fill_px)
    is_filled = np.isnan(found.disparity_px) & np.isfinite(disparity)
    sigma = np.where(is_filled, uncertainty.FILLED_PX, found.sigma_px)
    return DisparityMap(disparity_px=disparity, sigma_px=sigma)


def as_matches(found: DisparityMap) -> Matches:
    """Every known pixel as a separate match, the most precise first."""
    v, u = np.nonzero(found.valid_mask)
    sigma = found.sigma_px[v, u].astype(np.float64)
    order = np.argsort(sigma, kind="stable")
    none = np.full(len(order), -1, np.int32)
    return Matches(
        points_px=np.stack([u, v], axis=1)[order].astype(np.float64),
        disparity_px=found.disparity_px[v, u][order].astype(np.float64),
        sigma_px=sigma[order],
        score=1.0 / sigma[order],
        index_left=none,
        index_right=none,
    )


def _search(asked: MatchingSettings, width: int) -> Search:
    """The part of a search range that lies inside images of a given width."""
    first, last = max(asked.min_disparity, 1 - width), min(asked.max_disparity, width - 1)
    if last < first:
        raise InputError(
            f"disparities {asked.min_disparity}..{asked.max_disparity} all lie outside "
            f"the image, whose width is {width}"
        )
    return Search(first, last - first + 1)


def _semi_global(left: Image, other: Grey, search: Search, settings: DenseSettings) -> DisparityMap:
    grey = to_grey(left)
    choice = _by_strips(grey, other, search)
    patches = without_specks(median(choice.disparity_px), settings.speck_px)
    smoothed = smooth(at_image_edges(patches, left), grey)
    sigma = uncertainty.of_choice(choice, smoothed.spread_px, grey)
    return _with_sigma(smoothed.disparity_px, sigma)


def _opencv(left: Image, other: Grey, search: Search, settings: DenseSettings) -> DisparityMap:
    grey = to_grey(left)
    patches = without_specks(confirmed_three_ways(grey, other, search), settings.speck_px)
    smoothed = smooth(patches, grey)
    return _with_sigma(smoothed.disparity_px, uncertainty.of_image(smoothed.spread_px, grey))


def _with_sigma(disparity: Floats, sigma: Floats) -> DisparityMap:
    known = np.isfinite(disparity) & np.isfinite(sigma)
    nothing = np.float32(np.nan)
    return DisparityMap(
        disparity_px=np.where(known, disparity, nothing), sigma_px=np.where(known, sigma, nothing)
    )


_METHODS: dict[str, Callable[[Image, Grey, Search, DenseSettings], DisparityMap]] = {
    "semi-global": _semi_global,
    "opencv": _opencv,
}


def _by_strips(left: Grey, right: Grey, search: Search) -> Choice:
    """The choice at every pixel, in strips of rows that respect the memory limit."""
    height, width = left.shape
    bytes_per_row = 2 * np.int16().nbytes * width * search.depth
    rows = max(_STRIP_BYTES // bytes_per_row, 3 * _STRIP_MARGIN)
    if rows >= height:
        return _strip(left, right, search)
    whole = Choice(*(np.empty(left.shape, np.float32) for _ in Choice._fields))
    step = rows - 2 * _STRIP_MARGIN
    for first in range(0, height, step):
        top, end = max(0, first - _STRIP_MARGIN), min(height, first + step + _STRIP_MARGIN)
        part = _strip(left[top:end], right[top:end], search)
        for all_rows, some in zip(whole, part, strict=True):
            all_rows[first : first + step] = some[first - top : first - top + step]
    return whole


def _strip(left: Grey, right: Grey, search: Search) -> Choice:
    cost = cost_volume(left, right, search)
    total = aggregate(cost, left, PENALTIES)
    return choose(cost, total, search.first, search.size)
