"""Uncertainty of a refined disparity: its sigma, and the odds that the pair is right."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.records import Features
from recon.stereo.harmonics import DESCRIPTORS
from recon.stereo.kernels.simd import Floats, Integers
from recon.stereo.noise import gain

Array = NDArray[np.float64]

UNTUNED_SIGMA_PX = 0.6
"""Standard deviation of a disparity that is known to the pixel only."""
_VAGUE_SHARE_SQ = 0.1**2
"""Square of the share of a vertical edge's information at which half of the change is taken: an
edge along the row says nothing of the disparity, and must not break a good match."""
_LARGEST_CHANGE_PX = 0.7
"""A larger change means that phase and position disagree; position is kept then."""
_LARGEST_NOISE_VARIANCE = 0.32
"""Squared pixels; where noise alone moves a disparity by more, its phase tells nothing."""
_COHERENCE = 1.5
"""Variance of the mean of a scale's channels, of what it were if their noise was independent."""
_SCATTER_FACTOR = 2.0
"""Noise energy, of the median scatter of the channels of sure pairs round their common shift."""

# Variance of the tuned disparity. Fitted to the errors of recorded pairs with truth (Venus,
# Sawtooth, Cones, Map) and of rendered worlds, with noise of 0 to 10 grey levels added to both; the
# other recorded pairs and other worlds confirm it.
_FLOOR_VARIANCE = 0.0075
_LONELY_VARIANCE = 0.015
"""Added to the floor, over the square of the number of scales: one alone agrees with itself."""
_DISCORD_WEIGHT = 0.127
_NOISE_WEIGHT = 0.33
_VAGUENESS_WEIGHT = 0.06

# Log odds of a pair that is right: what matching says, less what noise could have made of nothing.
_NOISE_ODDS = -0.40
_NOISE_OF_EVEN_ODDS = 0.05
_LEAST_NOISE, _MOST_NOISE = 1e-3, 10.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tuning:
    """Sub-pixel refinement of whole-pixel disparities (N,)."""

    change_px: Array
    """To be added; 0 where nothing is known."""
    sigma_px: Array
    noise_variance: Array
    """Squared pixels that the images' noise alone makes of the change; infinite where the
    phase tells nothing, NaN where no filter is wide enough to tell."""


def solve(sums: Floats, white: Floats, calm_ratio: Array, is_sure: NDArray[np.bool_]) -> Tuning:
    """Solve the least squares problems of all pairs.

    Parameters
    ----------
    sums : (3 S + 2, N)
        For each scale the sums over its channels of weight k^2, weight k phi and weight phi^2; then
        those of the weight by the scales' nominal k^2, and the number of channels.
    white : (S, N)
        Energy that the noise of single pixels has in a scale's responses.
    calm_ratio : (S,)
        Energy of the calmest parts of the images, of that; noise has no more.
    is_sure : (N,)
        Pairs that are likely right: what their channels disagree by limits the noise, too.
    """
    if not len(white):
        nothing = np.zeros(sums.shape[1])
        return Tuning(
            change_px=nothing,
            sigma_px=nothing + UNTUNED_SIGMA_PX,
            noise_variance=np.full_like(nothing, np.nan),
        )
    information, moment, power = sums[:-2].reshape(len(white), 3, sums.shape[1]).swapaxes(0, 1)
    vertical, count = sums[-2:]
    whole_information = information.sum(axis=0)
    is_known = whole_information > 1e-6 * vertical
    safe = np.where(is_known, whole_information, 1.0)
    whole = np.where(is_known, moment.sum(axis=0), 0.0) / safe
    share_sq = (safe / np.where(vertical > 0, vertical, 1.0)) ** 2
    trust = np.where(is_known, share_sq / (share_sq + _VAGUE_SHARE_SQ), 0.0)
    scatter = np.maximum(power + whole * (whole * information - 2.0 * moment), 0.0)
    scatter_of_noise = scatter / (DESCRIPTORS * white)
    ratio = _noise_ratio(scatter_of_noise, calm_ratio, is_sure & is_known).astype(np.float32)
    noise = _COHERENCE * (ratio[:, None] * white * information).sum(axis=0) / safe**2
    noise[~is_known] = np.inf
    discord = np.sqrt(scatter.sum(axis=0) / safe) * count / np.maximum(count - 1.0, 1.0)
    variance = _FLOOR_VARIANCE + _LONELY_VARIANCE / len(white) ** 2
    variance = variance + _DISCORD_WEIGHT * trust * discord
    variance += _NOISE_WEIGHT * noise + _VAGUENESS_WEIGHT * (1.0 - trust)
    is_tuned = is_known & (trust * np.abs(whole) <= _LARGEST_CHANGE_PX)
    is_tuned &= noise <= _LARGEST_NOISE_VARIANCE
    sigma = np.minimum(np.sqrt(variance), UNTUNED_SIGMA_PX)
    return Tuning(
        change_px=np.where(is_tuned, trust * whole, 0.0),
        sigma_px=np.where(is_tuned, sigma, UNTUNED_SIGMA_PX),
        noise_variance=noise,
    )


def _noise_ratio(scatter: Array, calm_ratio: Array, is_sure: NDArray[np.bool_]) -> Array:
    """(S,) energy of noise in a scale's responses, of what the noise of single pixels gives."""
    if not is_sure.any():
        return np.maximum(calm_ratio, 1.0)
    limit = _SCATTER_FACTOR * np.median(scatter[:, is_sure], axis=1)
    return np.maximum(np.minimum(calm_ratio, limit), 1.0)


def white_energies(
    left: Features, right: Features, scales: Integers, grey: NDArray[np.uint8]
) -> Floats:
    """(S, N) energy that noise of single pixels has in responses at pixels of a brightness (N,)."""
    variance = 0.5 * (left.noise.by_grey**2 + right.noise.by_grey**2)
    gains = np.array([gain(left.widths_px[s]) for s in scales])
    energies: Floats = (gains[:, None] * variance).astype(np.float32)[:, grey]
    return energies


def calm_ratios(left: Features, right: Features, scales: Integers) -> Array:
    """(S,) energy of the images' calmest parts, of what noise of single pixels has there."""
    both = [(one.noise.by_scale[scales] / one.noise.level) ** 2 for one in (left, right)]
    return np.asarray(0.5 * (both[0] + both[1]), dtype=np.float64)


def updated_probability(prior: Array, noise_variance: Array) -> Array:
    """Probability that pairs are right, by what matching says and by what noise makes of nothing.

    Where noise alone moves a disparity by much, it may as well have made the pair.
    """
    with np.errstate(divide="ignore"):
        odds = np.log(prior) - np.log1p(-prior)
    noise = np.clip(noise_variance, _LEAST_NOISE, _MOST_NOISE)
    odds += np.nan_to_num(_NOISE_ODDS * np.log(noise / _NOISE_OF_EVEN_ODDS))
    return np.asarray(1.0 / (1.0 + np.exp(-odds)))
