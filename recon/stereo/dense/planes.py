"""Slanted planes of disparity, fitted to the matches of each superpixel."""

import numpy as np
from numpy.typing import NDArray

from recon.records import Matches
from recon.settings.stereo import DenseSettings
from recon.stereo.dense.superpixels import Superpixels
from recon.stereo.kernels.simd import Integers

Array = NDArray[np.float64]

_NUM_ROUNDS = 8
"""Of robust reweighting; the weights have settled by then."""
_FLATNESS = 2.0
"""Standard deviations, in pixels, by which a plane may slant from side to side without data."""
_LARGEST_SLANT = 1.0
"""Pixels of disparity a pixel: more would be seen from one eye only."""


def fit_planes(matches: Matches, patches: Superpixels, settings: DenseSettings) -> Array:
    """Planes ``d = a u + b v + c`` of the patches.

    Parameters
    ----------
    matches : Matches
        Fine tuned; each counts by its sigma, and less where it lies off the others' plane.
    patches : Superpixels
    settings : DenseSettings

    Returns
    -------
    planes : (S, 3)
        a, b, c; NaN where too few matches support one.
    """
    u, v = matches.points_px.astype(np.int64).T
    patch = patches.label[v, u]
    count = len(patches.sizes)
    offset = matches.points_px - patches.centres_px[patch]
    rows = np.column_stack([offset, np.ones(len(matches))])
    planes = _robust_start(matches.disparity_px, patch, count)
    for _ in range(_NUM_ROUNDS):
        error = matches.disparity_px - (rows * planes[patch]).sum(axis=1)
        # Geman and McClure: what lies on another surface loses its say.
        trust = 1.0 / (1.0 + (error / settings.spike_px) ** 2) ** 2
        weight = trust / matches.sigma_px**2
        planes = _solved(rows, matches.disparity_px, weight, patch, count, settings.segment_px)
    error = np.abs(matches.disparity_px - (rows * planes[patch]).sum(axis=1))
    support = np.bincount(patch[error <= settings.spike_px], minlength=count)
    steep = np.hypot(planes[:, 0], planes[:, 1]) > _LARGEST_SLANT
    planes[(support < settings.min_matches) | steep] = np.nan
    planes[:, 2] -= (planes[:, :2] * patches.centres_px).sum(axis=1)
    return planes


def disparity_of(planes: Array, label: Integers) -> Array:
    """(H, W) disparity of every pixel by the plane of its patch."""
    v, u = np.indices(label.shape)
    a, b, c = np.moveaxis(planes[label], -1, 0)
    disparity: Array = a * u + b * v + c
    return disparity


def _robust_start(disparity: Array, patch: Integers, count: int) -> Array:
    """Level planes at the median of each patch's disparities."""
    planes = np.zeros((count, 3))
    order = np.lexsort((disparity, patch))
    first = np.searchsorted(patch[order], np.arange(count))
    number = np.bincount(patch, minlength=count)
    filled = np.flatnonzero(number)
    planes[filled, 2] = disparity[order][first[filled] + number[filled] // 2]
    return planes


def _solved(
    rows: Array, disparity: Array, weight: Array, patch: Integers, count: int, side_px: float
) -> Array:
    """Weighted least squares planes round the patches' centres, slopes held to be small."""
    terms = weight[:, None, None] * rows[:, :, None] * rows[:, None, :]
    moments = (weight * disparity)[:, None] * rows
    normal = np.zeros((count, 3, 3))
    moment = np.zeros((count, 3))
    np.add.at(normal, patch, terms)
    np.add.at(moment, patch, moments)
    flat = (side_px / _FLATNESS) ** 2
    normal += np.diag([flat, flat, 1e-9])
    return np.asarray(np.linalg.solve(normal, moment[..., None])[..., 0])
