"""A disparity for every pixel that both images support: slanted planes over superpixels.

The thesis leaves this for the future (its chapter 5).
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.errors import InputError
from recon.records import Features, Matches, check_alike
from recon.settings.stereo import DenseSettings
from recon.stereo.dense.planes import disparity_of, fit_planes
from recon.stereo.dense.superpixels import Superpixels, cut
from recon.stereo.evaluation import seen_by_both
from recon.stereo.kernels.simd import Floats, Integers

Array = NDArray[np.float64]

_NUM_ROUNDS = 3
"""How often planes are passed on: so many patches away one is heard of."""
_NUM_SCALES = 2
"""The finest scales tell whether images agree; coarser ones look across edges."""


def densify(
    matches: Matches,
    left: Features,
    right: Features,
    image: NDArray[np.uint8],
    settings: DenseSettings,
) -> Array:
    """Spread matches over the superpixels of the left image.

    Planes are fitted to the matches of each patch, then offered to its neighbours: a patch takes
    the plane by which the phases of both images agree the most.

    Parameters
    ----------
    matches : Matches
        Fine tuned.
    left, right : Features
        Of the two images.
    image : (H, W) or (H, W, 3) uint8
        The left image.
    settings : DenseSettings

    Returns
    -------
    disparity_px : (H, W) float64
        NaN where the images support no plane, and where the right eye sees something nearer.
    """
    height, width = image.shape[:2]
    check_alike(left, right)
    if left.grey.shape != (height, width):
        raise InputError(
            f"features are of an image {left.grey.shape}, but the image has shape {(height, width)}"
        )
    if len(matches) and not (matches.points_px < (width, height)).all():
        raise InputError(f"matches lie outside the image of {width} x {height} pixels")
    patches = cut(image, settings.segment_px)
    planes = fit_planes(matches.select(~is_spike(matches, settings)), patches, settings)
    planes, similarity = _passed_on(planes, patches, left, right)
    planes[similarity < settings.min_similarity] = np.nan
    disparity = disparity_of(planes, patches.label)
    disparity[~seen_by_both(disparity)] = np.nan
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


def _passed_on(
    planes: Array, patches: Superpixels, left: Features, right: Features
) -> tuple[Array, Array]:
    """The plane of each patch, its own or a neighbour's, that the images support the most.

    With its similarity, the mean similarity of the phases over the patch; -inf without a plane.
    """
    planes, similarity = planes.copy(), _patch_similarity(planes, patches, left, right)
    for neighbour in np.tile(patches.neighbours.T, (_NUM_ROUNDS, 1)):
        offered = planes[neighbour]
        offered[(neighbour < 0) | (offered == planes).all(axis=1)] = np.nan
        found = _patch_similarity(offered, patches, left, right)
        better = found > similarity
        planes[better], similarity[better] = offered[better], found[better]
    return planes, similarity


def _patch_similarity(
    planes: Array, patches: Superpixels, left: Features, right: Features
) -> Array:
    """(S,) mean of ``c cos(phase difference)`` over the pixels of each patch (Eqs 16 to 18)."""
    sums = np.zeros(len(patches.sizes))
    _add_similarity(left.planes, right.planes, patches.label, planes, sums)
    return np.where(np.isfinite(planes[:, 0]), sums / np.maximum(patches.sizes, 1), -np.inf)


@njit(cache=True, error_model="numpy")
def _add_similarity(
    left: Floats, right: Floats, label: Integers, planes: Array, sums: Array
) -> None:
    """Add up the similarity of the pixels of each patch that has a plane."""
    height, width = label.shape
    for v in range(height):
        for u in range(width):
            patch = label[v, u]
            a, b, c = planes[patch]
            u_right = u - (a * u + b * v + c)
            if 0 <= u_right < width - 1:  # false where there is no plane
                sums[patch] += _similarity(left[v], u, right[v], u_right)


@njit(cache=True, error_model="numpy")
def _similarity(left: Floats, u: int, right: Floats, u_right: float) -> float:
    """Mean similarity of a pixel's channels and those between two right pixels."""
    first = int(u_right)
    part = np.float32(u_right - first)
    num_scales = min(left.shape[0], _NUM_SCALES)
    total = np.float32(0.0)
    for s in range(num_scales):
        for o in range(left.shape[1]):
            re, im = left[s, o, 0, u], left[s, o, 1, u]
            reals, imags = right[s, o, 0], right[s, o, 1]
            real = reals[first] + part * (reals[first + 1] - reals[first])
            imag = imags[first] + part * (imags[first + 1] - imags[first])
            energy = max(re * re + im * im, real * real + imag * imag)
            total += (re * real + im * imag) / max(energy, np.float32(1e-3))
    return float(total / np.float32(num_scales * left.shape[1]))
