"""Sub-pixel matching of the feature points of two images; large images strip by strip."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.records import Features, Matches
from recon.settings import Settings
from recon.stereo.features import detect_both, to_grey
from recon.stereo.harmonics import DESCRIPTORS
from recon.stereo.kernels.sorting import falling
from recon.stereo.matching.matching import BLOCK_PX, match, match_whole_images
from recon.stereo.noise import noise_level
from recon.stereo.subpixel import refine

Image = NDArray[np.uint8]

_STRIP_BYTES = 800 << 20
"""Memory limit of the filter responses of both images' strips."""
_MARGIN_ROWS = 2 * BLOCK_PX
"""Rows above and below a strip within reach of filters and support windows."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SparseMatches:
    """Matches of two images, with statistics of the images."""

    matches: Matches
    num_features: int | None
    """Of the left image; None if the matcher takes whole images."""
    image_noise: tuple[float, float]
    """Standard deviation of the noise of the left and the right image, grey levels."""


def match_sparse(
    left: Image,
    right: Image,
    settings: Settings,
    stated_range: tuple[int, int] | None = None,
    residual_px: float | None = None,
) -> SparseMatches:
    """Match two rectified images as the settings say.

    Images whose filter responses would exceed the memory limit are matched in strips of rows, each
    with the settings' share of feature points.

    Parameters
    ----------
    left, right : (H, W) or (H, W, 3) uint8
    settings : Settings
    stated_range : (min, max), optional
        Search range in pixels, used if the settings do not define one.
    residual_px : float, optional
        Of the rig, used if the settings do not define one; see `refine`.
    """
    search = settings.matching.searching(stated_range)
    whole = match_whole_images(left, right, search)
    if whole is not None:
        noise = noise_level(to_grey(left)), noise_level(to_grey(right))
        return SparseMatches(matches=whole, num_features=None, image_noise=noise)
    parts = [
        _match_strip(left, right, settings, stated_range, residual_px, rows)
        for rows in _strips(left.shape, settings.features.widths_px)
    ]
    return parts[0] if len(parts) == 1 else _joined(parts, search.keep)


def match_features(
    features_left: Features,
    features_right: Features,
    settings: Settings,
    stated_range: tuple[int, int] | None = None,
    residual_px: float | None = None,
) -> Matches:
    """Match the features of two rectified images with sub-pixel precision."""
    given = settings.matching.residual_px
    # Pairs of similar phase and magnitude, cross-checked (Eqs 15 to 18).
    matches = match(features_left, features_right, settings.matching.searching(stated_range))
    # Refined by the residual phase (Eqs 20, 21).
    return refine(matches, features_left, features_right, residual_px if given is None else given)


def _strips(shape: tuple[int, ...], widths_px: tuple[float, ...]) -> Iterator[tuple[int, int]]:
    """First and end row of each strip; every image block lies in one strip."""
    height, width = shape[:2]
    complex_bytes = 2 * np.float32().nbytes
    bytes_per_row = 2 * width * len(widths_px) * DESCRIPTORS * complex_bytes
    rows = max(_STRIP_BYTES // bytes_per_row // BLOCK_PX * BLOCK_PX, 6 * _MARGIN_ROWS)
    if rows >= height:
        yield 0, height
        return
    step = rows - 2 * _MARGIN_ROWS
    for first in range(0, height, step):
        yield first, min(first + step, height)


def _match_strip(
    left: Image,
    right: Image,
    settings: Settings,
    stated_range: tuple[int, int] | None,
    residual_px: float | None,
    rows: tuple[int, int],
) -> SparseMatches:
    first, end = rows
    top, bottom = max(0, first - _MARGIN_ROWS), min(len(left), end + _MARGIN_ROWS)
    # Oriented features of both images at several scales (Eqs 11 to 14).
    features = detect_both(left[top:bottom], right[top:bottom], settings.features)
    matches = match_features(*features, settings, stated_range, residual_px)
    noise = features[0].noise.level, features[1].noise.level
    v = features[0].points_px[:, 1] + top
    num_features = int(((v >= first) & (v < end)).sum())
    if bottom - top < len(left):
        matches = _of_rows(matches, top, rows)
    return SparseMatches(matches=matches, num_features=num_features, image_noise=noise)


def _of_rows(matches: Matches, top: int, rows: tuple[int, int]) -> Matches:
    """The matches in some rows of the image, from a strip whose first row is `top`."""
    moved = matches.points_px + np.array([0.0, top])
    inside = (moved[:, 1] >= rows[0]) & (moved[:, 1] < rows[1])
    no_feature = np.full(len(matches), -1, np.int32)
    return replace(
        matches, points_px=moved, index_left=no_feature, index_right=no_feature
    ).select(inside)  # fmt: skip


def _joined(parts: list[SparseMatches], keep: int | None) -> SparseMatches:
    """The matches of all strips, most confident first, and the mean noise."""
    columns = {
        name: np.concatenate([getattr(part.matches, name) for part in parts])
        for name in Matches.__slots__
    }
    order = falling(columns["score"].astype(np.float32))[slice(0, keep)]
    left, right = np.mean([part.image_noise for part in parts], axis=0).tolist()
    return SparseMatches(
        matches=Matches(**columns).select(order),
        num_features=sum(part.num_features or 0 for part in parts),
        image_noise=(left, right),
    )
