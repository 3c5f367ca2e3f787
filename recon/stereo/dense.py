"""A disparity for every pixel near matches: slanted planes over segments of the picture.

The thesis leaves this for the future (its chapter 5).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from skimage.segmentation import slic

from recon.errors import InputError
from recon.records import Matches
from recon.settings.stereo import DenseSettings

Array = NDArray[np.float64]

_COMPACTNESS = 12.0
"""How much a segment keeps together rather than following the colours."""
_NUM_ROUNDS = 8
"""Of robust reweighting; the weights have settled by then."""
_FLATNESS = 2.0
"""Standard deviations, in pixels, by which a plane may slant from side to side without data."""
_LARGEST_SLANT = 1.0
"""Pixels of disparity a pixel: more would be seen from one eye only."""


def densify(matches: Matches, image: NDArray[np.uint8], settings: DenseSettings) -> Array:
    """Spread matches over the segments of the left picture.

    Parameters
    ----------
    matches : Matches
        Fine tuned.
    image : (H, W) or (H, W, 3) uint8
        The left picture.
    settings : DenseSettings

    Returns
    -------
    disparity_px : (H, W) float64
        NaN where too few matches support a segment's plane.
    """
    height, width = image.shape[:2]
    if len(matches) and not (matches.points_px < (width, height)).all():
        raise InputError(f"matches lie outside the image of {width} x {height} pixels")
    label = _segments(image, settings)
    kept = matches.select(~is_spike(matches, settings))
    planes = _planes(kept, label, settings)
    v, u = np.indices((height, width))
    centre = _centres(label)
    slope_u, slope_v, middle = np.moveaxis(planes[label], -1, 0)
    disparity: Array = middle + slope_u * (u - centre[label, 0]) + slope_v * (v - centre[label, 1])
    return disparity


def is_spike(matches: Matches, settings: DenseSettings) -> NDArray[np.bool_]:
    """(M,) matches that most of their neighbours contradict."""
    count = min(settings.num_neighbours + 1, len(matches))
    if count < 3:
        return np.zeros(len(matches), dtype=bool)
    neighbours = np.asarray(cKDTree(matches.points_px).query(matches.points_px, k=count)[1])
    difference = np.abs(matches.disparity_px[neighbours[:, 1:]] - matches.disparity_px[:, None])
    lonely = (difference <= settings.spike_px).mean(axis=1) < settings.spike_share
    return np.asarray(lonely)


def _segments(image: NDArray[np.uint8], settings: DenseSettings) -> NDArray[np.int64]:
    """(H, W) segment of each pixel."""
    number = max(1, round(image.shape[0] * image.shape[1] / settings.segment_px**2))
    channel_axis = -1 if image.ndim == 3 else None
    return np.asarray(
        slic(
            image,
            n_segments=number,
            compactness=_COMPACTNESS if image.ndim == 3 else _COMPACTNESS / 100,
            start_label=0,
            channel_axis=channel_axis,
        )
    )


def _centres(label: NDArray[np.int64]) -> Array:
    """(S, 2) mean u, v of the segments."""
    v, u = np.indices(label.shape)
    count = np.maximum(np.bincount(label.ravel()), 1)
    sums = [np.bincount(label.ravel(), weights=x.ravel()) for x in (u, v)]
    return np.column_stack(sums) / count[:, None]


def _planes(matches: Matches, label: NDArray[np.int64], settings: DenseSettings) -> Array:
    """(S, 3) slopes and middle value of each segment's plane; NaN where it has none."""
    u, v = matches.points_px.astype(np.int64).T
    segment = label[v, u]
    num_segments = int(label.max()) + 1
    offset = matches.points_px - _centres(label)[segment]
    rows = np.column_stack([offset, np.ones(len(matches))])
    weight = 1.0 / matches.sigma_px**2
    planes = _robust_start(matches.disparity_px, segment, num_segments)
    for _ in range(_NUM_ROUNDS):
        error = matches.disparity_px - (rows * planes[segment]).sum(axis=1)
        # Geman and McClure: what lies on another surface loses its say.
        trust = 1.0 / (1.0 + (error / settings.spike_px) ** 2) ** 2
        planes = _solved(rows, matches.disparity_px, weight * trust, segment, planes, settings)
    error = np.abs(matches.disparity_px - (rows * planes[segment]).sum(axis=1))
    support = np.bincount(segment[error <= settings.spike_px], minlength=num_segments)
    steep = np.hypot(planes[:, 0], planes[:, 1]) > _LARGEST_SLANT
    planes[(support < settings.min_matches) | steep] = np.nan
    return planes


def _robust_start(disparity: Array, segment: NDArray[np.int64], num_segments: int) -> Array:
    """Level planes at the median of each segment's disparities."""
    planes = np.zeros((num_segments, 3))
    order = np.lexsort((disparity, segment))
    first = np.searchsorted(segment[order], np.arange(num_segments))
    count = np.bincount(segment, minlength=num_segments)
    filled = np.flatnonzero(count)
    planes[filled, 2] = disparity[order][first[filled] + count[filled] // 2]
    return planes


def _solved(
    rows: Array,
    disparity: Array,
    weight: Array,
    segment: NDArray[np.int64],
    planes: Array,
    settings: DenseSettings,
) -> Array:
    """Weighted least squares planes of all segments at once, slopes held to be small."""
    normal = np.zeros((len(planes), 3, 3))
    moment = np.zeros((len(planes), 3))
    np.add.at(normal, segment, weight[:, None, None] * rows[:, :, None] * rows[:, None, :])
    np.add.at(moment, segment, (weight * disparity)[:, None] * rows)
    flat = (settings.segment_px / _FLATNESS) ** 2
    normal += np.diag([flat, flat, 1e-9])
    return np.asarray(np.linalg.solve(normal, moment[..., None])[..., 0])
