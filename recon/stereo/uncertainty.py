"""Uncertainty of a refined disparity: its sigma, and the probability that the pair is correct."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.records import Features
from recon.stereo import chance
from recon.stereo.harmonics import DESCRIPTORS
from recon.stereo.kernels.simd import FAST, Floats, Integers
from recon.stereo.kernels.sorting import median
from recon.stereo.neighbours import Neighbours
from recon.stereo.noise import gain

Array = NDArray[np.float64]

_VAGUE_SHARE_SQ = 0.1**2
"""Squared share of a vertical edge's information at which half of the change is applied: an edge
along the row is uninformative about the disparity, and must not spoil a good match."""
_LEAST_TRUST = 0.05
"""Share of the change that is applied below which a disparity counts as whole: an edge that close
to the row has no disparity of its own, but that of what stands near."""
_LARGEST_CHANGE_PX = 0.7
"""A larger change means that phase and position disagree; then the position is kept."""
_LARGEST_NOISE_VARIANCE = 0.32
"""Squared pixels; if noise alone moves a disparity by more, its phase is uninformative."""
_COHERENCE = 1.5
"""Variance of the mean of a scale's channels, relative to that of independent noise."""
_SCATTER_FACTOR = 2.0
"""Noise energy relative to the median scatter of the channels of reliable pairs."""

# Variance of a disparity that is correct to a pixel, beyond those due to noise and to the rig.
# Fitted to the errors of rendered worlds, whose rig is exact, and of recorded pairs without the
# error that neighbouring pixels share, with noise of 0 to 10 grey levels; other worlds confirm it.
_LEAST_VARIANCE = 0.0001
_SURFACE_VARIANCE = 0.013
"""Of a match without company, as at silhouettes: there, surfaces curve away within a filter."""
_DISCORD_WEIGHT = 1.6
"""Relative to the variance that the scatter of the channels implies, beyond that due to noise."""
_ALONG_VARIANCE = 0.08
"""Of a disparity whose edge is along the row."""
_DOUBT_VARIANCE, _EVEN_DOUBT = 0.04, 0.028
"""Of doubtful pairs, which lie at edges of surfaces; and the probability of a mismatch at which
half of it is reached."""
_LARGEST_VARIANCE = 0.2
"""Larger errors are mismatches; approached smoothly."""
_WHOLE_VARIANCE, _WRONG_VARIANCE = 0.19, 0.13
"""Of a disparity known only to the pixel, and what is added if it is certainly wrong."""

_WHOLE, _INFORMATION, _TRUST, _NOISE, _DISCORD = 0, 1, 2, 3, 4
"""Rows of the shift's estimate of each pair; the last two are its variances due to noise alone, and
due to the scatter of the channels beyond that."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prior:
    """The evidence of matching about whole-pixel disparities (N,)."""

    probability: Array
    """That the pairs are correct; NaN if unknown."""
    is_sure: NDArray[np.bool_]
    """Pairs that are likely correct: the scatter of their channels limits the noise, too."""
    neighbours: Neighbours


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tuning:
    """Sub-pixel refinement of whole-pixel disparities (N,)."""

    change_px: Floats
    """Change to be added; 0 where unknown."""
    is_whole: NDArray[np.bool_]
    """Disparities that stay known only to the pixel."""
    sigma_px: Floats
    probability: Array
    """That the pairs are correct; NaN if unknown."""


def solve(
    sums: Floats, white: Floats, calm_ratio: Array, prior: Prior, residual_px: float
) -> Tuning:
    """Solve the least squares problems of all pairs.

    Parameters
    ----------
    sums : (3 S + 2, N)
        For each scale the sums over its channels of weight k^2, weight k phi and weight phi^2; then
        those of the weight by the scales' nominal k^2, and the number of channels.
    white : (S, N)
        Energy of single-pixel noise in a scale's responses.
    calm_ratio : (S,)
        Energy of the calmest image regions relative to `white`; an upper limit for noise.
    prior : Prior
    residual_px : float
        Root mean square error of the disparities due to the rig's calibration.
    """
    num = sums.shape[1]
    shifts, scatter = np.zeros((5, num), np.float32), np.empty((len(white), num), np.float32)
    probability = prior.probability
    if len(white):
        scatter_of_sure = np.empty_like(scatter)
        num_sure = _shift(sums, white, prior.is_sure, shifts, scatter, scatter_of_sure)
        ratio = _noise_ratio(scatter_of_sure[:, :num_sure], calm_ratio).astype(np.float32)
        _split(sums, white, ratio, scatter, shifts)
        probability = chance.probability(
            probability, shifts[_NOISE], shifts[_TRUST], prior.neighbours
        )
    # Unknown probabilities do not make a pair doubtful.
    wrong = np.nan_to_num(1.0 - probability).astype(np.float32)
    tuned = np.zeros_like(wrong), np.empty_like(wrong), np.ones(num, np.bool_)
    _weigh(shifts, wrong, prior.neighbours.company, np.float32(residual_px**2), tuned)
    change, sigma, is_whole = tuned
    return Tuning(change_px=change, is_whole=is_whole, sigma_px=sigma, probability=probability)


@njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)
def _shift(
    sums: Floats,
    white: Floats,
    is_sure: NDArray[np.bool_],
    shifts: Floats,
    scatter: Floats,
    scatter_of_sure: Floats,
) -> int:
    """Write each pair's shift, its information and trust, and the scatter by scale.

    If the shift is unknown, all are 0. The scatter of reliable pairs is also written consecutively,
    in units of single-pixel noise; returns their number.
    """
    num_scales, num_sure = len(scatter), 0
    for i in range(scatter.shape[1]):
        information = moment = np.float32(0)
        for s in range(num_scales):
            information += sums[3 * s, i]
            moment += sums[3 * s + 1, i]
        vertical = sums[3 * num_scales, i]
        is_known = information > np.float32(1e-6) * vertical
        whole = moment / information if is_known else np.float32(0)
        share = information / vertical if is_known else np.float32(0)
        share_sq = share * share
        shifts[_WHOLE, i] = whole
        shifts[_INFORMATION, i] = information if is_known else np.float32(0)
        shifts[_TRUST, i] = share_sq / (share_sq + np.float32(_VAGUE_SHARE_SQ))
        for s in range(num_scales):
            rest = whole * (whole * sums[3 * s, i] - 2 * sums[3 * s + 1, i])
            scatter[s, i] = max(sums[3 * s + 2, i] + rest, np.float32(0))
            noise = np.float32(DESCRIPTORS) * white[s, i]
            scatter_of_sure[s, num_sure] = scatter[s, i] / noise
        num_sure += is_known and is_sure[i]
    return num_sure


@njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)
def _split(sums: Floats, white: Floats, ratio: Floats, scatter: Floats, shifts: Floats) -> None:
    """Write each shift's variance due to noise, infinite if it is unknown, and due to discord."""
    num_scales = len(scatter)
    for i in range(scatter.shape[1]):
        information, count = shifts[_INFORMATION, i], sums[3 * num_scales + 1, i]
        noise = discord = np.float32(0)
        for s in range(num_scales):
            noise += ratio[s] * white[s, i] * sums[3 * s, i]
            discord += scatter[s, i]
        is_known = information > 0
        safe = information if is_known else np.float32(1)
        noise = np.float32(_COHERENCE) * noise / (safe * safe)
        discord = discord / (safe * max(count - 1, np.float32(1)))
        shifts[_NOISE, i] = noise if is_known else np.float32(np.inf)
        shifts[_DISCORD, i] = max(discord - noise, np.float32(0))


@njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)
def _weigh(
    shifts: Floats,
    wrong: Floats,
    company: Floats,
    rig_variance: float,
    tuned: tuple[Floats, Floats, NDArray[np.bool_]],
) -> None:
    """Write each pair's change, its sigma, and whether it stays whole; `wrong` are the doubts."""
    change, sigma, is_whole = tuned
    floor = np.float32(_LEAST_VARIANCE) + rig_variance
    whole_floor = np.float32(_WHOLE_VARIANCE) + rig_variance
    even_doubt = np.float32(_EVEN_DOUBT**2)
    for i in range(wrong.size):
        whole, trust, noise = shifts[_WHOLE, i], shifts[_TRUST, i], shifts[_NOISE, i]
        is_near = trust * abs(whole) <= np.float32(_LARGEST_CHANGE_PX)
        is_known = shifts[_INFORMATION, i] > 0
        is_refined = is_known and is_near and noise <= np.float32(_LARGEST_NOISE_VARIANCE)
        is_whole[i] = not (is_refined and trust >= np.float32(_LEAST_TRUST))
        if not is_refined:
            variance = whole_floor + np.float32(_WRONG_VARIANCE) * wrong[i]
        else:
            change[i] = trust * whole
            scatter = noise + np.float32(_DISCORD_WEIGHT) * shifts[_DISCORD, i]
            variance = trust * trust * scatter
            variance += (1 - trust) * (1 - trust) * np.float32(_ALONG_VARIANCE)
            variance += np.float32(_SURFACE_VARIANCE) * (1 - company[i])
            doubt = wrong[i] * wrong[i]
            variance += np.float32(_DOUBT_VARIANCE) * doubt / (doubt + even_doubt)
            share = variance / np.float32(_LARGEST_VARIANCE)
            variance = floor + variance / np.sqrt(1 + share * share)
        sigma[i] = np.sqrt(variance)


def _noise_ratio(scatter: Floats, calm_ratio: Array) -> Array:
    """(S,) energy of noise in a scale's responses, relative to that of single-pixel noise."""
    if not scatter.shape[1]:
        return np.maximum(calm_ratio, 1.0)
    limit = _SCATTER_FACTOR * np.array([median(of_scale) for of_scale in scatter])
    return np.asarray(np.maximum(np.minimum(calm_ratio, limit), 1.0), dtype=np.float64)


def white_energies(
    left: Features, right: Features, scales: Integers, grey: NDArray[np.uint8]
) -> Floats:
    """(S, N) energy of single-pixel noise in responses at pixels of brightness (N,)."""
    variance = 0.5 * (left.noise.by_grey**2 + right.noise.by_grey**2)
    gains = np.array([gain(left.widths_px[s]) for s in scales])
    energies: Floats = (gains[:, None] * variance).astype(np.float32)[:, grey]
    return energies


def calm_ratios(left: Features, right: Features, scales: Integers) -> Array:
    """(S,) energy of the images' calmest regions, relative to that of single-pixel noise."""
    both = [(one.noise.by_scale[scales] / one.noise.level) ** 2 for one in (left, right)]
    return np.asarray(0.5 * (both[0] + both[1]), dtype=np.float64)
