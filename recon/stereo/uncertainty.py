"""Uncertainty of a refined disparity: its sigma, and how far noise alone moves it."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.records import Features
from recon.stereo.harmonics import DESCRIPTORS
from recon.stereo.kernels.simd import FAST, Floats, Integers
from recon.stereo.kernels.sorting import median
from recon.stereo.noise import gain

Array = NDArray[np.float64]

UNTUNED_SIGMA_PX = 0.6
"""Standard deviation of a disparity known only to the pixel."""
_VAGUE_SHARE_SQ = 0.1**2
"""Squared share of a vertical edge's information at which half of the change is applied: an edge
along the row is uninformative about the disparity, and must not spoil a good match."""
_LARGEST_CHANGE_PX = 0.7
"""A larger change means that phase and position disagree; then the position is kept."""
_LARGEST_NOISE_VARIANCE = 0.32
"""Squared pixels; if noise alone moves a disparity by more, its phase is uninformative."""
_COHERENCE = 1.5
"""Variance of the mean of a scale's channels, relative to that of independent noise."""
_SCATTER_FACTOR = 2.0
"""Noise energy relative to the median scatter of the channels of reliable pairs."""

# Variance of a refined disparity that is correct to a pixel, beyond those due to noise and to the
# rig. Fitted to the errors of rendered worlds, whose rig is exact, with noise of 0 to 10 grey
# levels; other worlds confirm it.
_SURFACE_VARIANCE = 0.0045
"""Surfaces curve away within a filter, most of all at their silhouettes."""
_DISCORD_WEIGHT = 1.7
"""Relative to the variance that the scatter of the channels implies, beyond that due to noise."""
_WHOLE_PIXEL_VARIANCE = 1 / 12
_DOUBT_WEIGHT = 11.0
"""Squared pixels per squared odds of a mismatch: such pairs lie at edges of surfaces."""
_NOISE_OF_HALF_DOUBT = 0.009
"""Variance due to noise at which half of these odds are attributed to noise."""
_LARGEST_VARIANCE = 0.115

_WHOLE, _INFORMATION, _TRUST, _PROBABILITY = 0, 1, 2, 3
"""Rows of the shift's estimate of each pair; the last is the probability by matching."""
_LEAST_PROBABILITY = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prior:
    """The evidence of matching about whole-pixel disparities (N,)."""

    probability: Array
    """That the pairs are correct; NaN if unknown."""
    is_sure: NDArray[np.bool_]
    """Pairs that are likely correct: the scatter of their channels limits the noise, too."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tuning:
    """Sub-pixel refinement of whole-pixel disparities (N,)."""

    change_px: Floats
    """Change to be added; 0 where unknown."""
    sigma_px: Floats
    noise_variance: Floats
    """Variance of the change due to image noise alone, squared pixels; infinite where the phase is
    uninformative, NaN where no filter is wide enough."""
    trust: Floats
    """Share of the change that is applied, from 0, if the edge is along the row, to 1."""


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
    if not len(white):
        nothing = np.zeros(sums.shape[1], np.float32)
        return Tuning(
            change_px=nothing,
            sigma_px=nothing + np.float32(UNTUNED_SIGMA_PX),
            noise_variance=np.full_like(nothing, np.nan),
            trust=nothing,
        )
    num = sums.shape[1]
    shifts, scatter = np.empty((4, num), np.float32), np.empty((len(white), num), np.float32)
    scatter_of_sure = np.empty_like(scatter)
    num_sure = _shift(sums, white, prior.is_sure, shifts, scatter, scatter_of_sure)
    ratio = _noise_ratio(scatter_of_sure[:, :num_sure], calm_ratio).astype(np.float32)
    # Unknown probabilities do not make a pair doubtful.
    shifts[_PROBABILITY] = np.nan_to_num(prior.probability, nan=1.0)
    tuned = np.empty((3, num), np.float32)
    _weigh(sums, white, ratio, shifts, scatter, np.float32(residual_px**2), tuned)
    change, sigma, noise = tuned
    return Tuning(change_px=change, sigma_px=sigma, noise_variance=noise, trust=shifts[_TRUST])


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
def _weigh(
    sums: Floats,
    white: Floats,
    ratio: Floats,
    shifts: Floats,
    scatter: Floats,
    rig_variance: float,
    tuned: Floats,
) -> None:
    """Write the change of each pair's disparity, its sigma, and its variance due to noise."""
    num_scales = len(scatter)
    floor = np.float32(_SURFACE_VARIANCE) + rig_variance
    untuned = max(np.float32(UNTUNED_SIGMA_PX), np.sqrt(rig_variance))
    for i in range(scatter.shape[1]):
        information, whole = shifts[_INFORMATION, i], shifts[_WHOLE, i]
        trust, count = shifts[_TRUST, i], sums[3 * num_scales + 1, i]
        noise = discord = np.float32(0)
        for s in range(num_scales):
            noise += ratio[s] * white[s, i] * sums[3 * s, i]
            discord += scatter[s, i]
        is_known = information > 0
        safe = information if is_known else np.float32(1)
        noise = np.float32(_COHERENCE) * noise / (safe * safe)
        discord = max(discord / (safe * max(count - 1, np.float32(1))) - noise, np.float32(0))
        variance = trust * trust * (noise + np.float32(_DISCORD_WEIGHT) * discord)
        variance += (1 - trust) * (1 - trust) * np.float32(_WHOLE_PIXEL_VARIANCE)
        odds = 1 / max(shifts[_PROBABILITY, i], np.float32(_LEAST_PROBABILITY)) - 1
        odds = odds / (1 + noise / np.float32(_NOISE_OF_HALF_DOUBT))
        variance += np.float32(_DOUBT_WEIGHT) * odds * odds
        variance = floor + min(variance, np.float32(_LARGEST_VARIANCE))
        is_tuned = is_known and trust * abs(whole) <= np.float32(_LARGEST_CHANGE_PX)
        is_tuned = is_tuned and noise <= np.float32(_LARGEST_NOISE_VARIANCE)
        tuned[0, i] = trust * whole if is_tuned else np.float32(0)
        tuned[1, i] = np.sqrt(variance) if is_tuned else untuned
        tuned[2, i] = noise if is_known else np.float32(np.inf)


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
