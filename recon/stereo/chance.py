"""Probability that a pair is correct, in view of the noise.

Where noise alone moves a disparity considerably, it may have created the pair. On plain ground it
has; on a faint texture hardly ever, though the scores of both are low. Which of the two an image
shows, only its pairs together tell: those that noise created have the scores of pure noise, and
disagree with the pairs around them. So the share of such pairs, and the scores of the others, are
estimated from all pairs of the images.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.kernels.simd import FAST, Floats, Integers
from recon.stereo.neighbours import Neighbours

Array = NDArray[np.float64]

# Fitted to rendered worlds and to recorded pairs, with noise of 0 to 10 grey levels; each recorded
# pair is confirmed by the others.
_MEAN, _SPREAD = -1.45, 0.5
"""Log odds by matching of the pairs that noise creates."""
_CORRECT, _CORRECT_IN_COMPANY = -3.5, 6.3
"""Log odds that such a pair is correct to a pixel if no block around it agrees, and what is added
if all do: some that look like noise are the faint ones of a surface, whose disparity they have."""
_GROWTH = 0.5
"""Log odds that noise created a pair, per natural logarithm of the variance due to noise."""
_DISSENT = 12.0
"""Log odds that noise created a pair, if none of its neighbours agrees instead of all."""
_FADING = -0.5
"""Log odds by matching of all other pairs, per natural logarithm of the same."""
_EVEN_NOISE = 0.05
"""Variance due to noise at which half of its effect on the odds is reached, squared pixels."""
_LEAST_NOISE, _MOST_NOISE = 0.02, 10.0
"""Less noise creates no pairs."""
_OFFSET = 0.65
"""Of the log odds of all other pairs, from those by matching."""
_FAINT = 1.0
"""Added if they are noisy: noise reduces the scores of correct pairs, too."""
_ALONG = -3.0
"""Added instead if their edges are along the row, which matches anywhere on it."""
_CONSENT = 6.0
"""Added if they are noisy, and all of their neighbours agree instead of none."""
_EVEN_TRUST = 0.02

_NUM_SAMPLES = 1024
_NUM_ITERATIONS = 15
_TYPICAL_MEAN, _TYPICAL_SPREAD, _TYPICAL_COUNT = 2.0, 1.5, 10.0
"""Prior for the scores of the other pairs, and its weight as a number of samples."""
_LARGEST_BIAS = 8.0


class _Share(NamedTuple):
    """The pairs that noise created among those that it may have created, and the others."""

    bias: float
    """Log odds that noise created a pair, at `_EVEN_NOISE`."""
    mean: float
    """Log odds by matching of the others, at `_EVEN_NOISE`."""
    spread: float


def probability(
    prior: Array, noise_variance: Floats, trust: Floats, neighbours: Neighbours
) -> Array:
    """Probability that pairs are correct (N,), from matching and from the effect of noise.

    Parameters
    ----------
    prior : (N,)
        Probability by matching; NaN if unknown, which it then stays.
    noise_variance : (N,)
        Variance of the disparity due to noise alone, squared pixels.
    trust : (N,)
        From 0, if the edge is along the row, to 1.
    neighbours : Neighbours
    """
    log_odds = np.log(np.clip(prior, 1e-6, None) / np.clip(1.0 - prior, 1e-6, None))
    noise = np.minimum(noise_variance, np.float32(_MOST_NOISE))
    known = np.flatnonzero(np.isfinite(log_odds))
    rows = known[noise[known] > _LEAST_NOISE]
    rows = rows[:: max(1, len(rows) // _NUM_SAMPLES)]
    some = log_odds[rows], np.log(noise[rows] / _EVEN_NOISE), neighbours.agreement[rows]
    found = prior.copy()
    _update(known, (log_odds, noise, trust), neighbours, _estimate(*some), found)
    return found


@njit(cache=True, error_model="numpy", fastmath=FAST, nogil=True)
def _estimate(log_odds: Array, log_noise: Floats, agreement: Floats) -> _Share:
    """Estimate the share by expectation maximisation."""
    share = _Share(0.0, _TYPICAL_MEAN, _TYPICAL_SPREAD)
    for _ in range(_NUM_ITERATIONS):
        slope = 1.0
        excess = 0.0
        count, first, second = _TYPICAL_COUNT, 0.0, 0.0
        for i in range(log_odds.size):
            before = _odds(log_noise[i], agreement[i], share)
            after = _logistic(before + _evidence(log_odds[i], log_noise[i], share))
            before = _logistic(before)
            excess += after - before
            slope += before * (1.0 - before)
            value = log_odds[i] - _FADING * log_noise[i] - _TYPICAL_MEAN
            count += 1.0 - after
            first += (1.0 - after) * value
            second += (1.0 - after) * value * value
        change = first / count
        variance = (second + _TYPICAL_COUNT * _TYPICAL_SPREAD**2) / count - change * change
        spread = max(np.sqrt(max(variance, 0.0)), _SPREAD)
        mean = max(_TYPICAL_MEAN + change, _MEAN + 1.0)
        bias = min(max(share.bias + 2.0 * excess / slope, -_LARGEST_BIAS), _LARGEST_BIAS)
        share = _Share(bias, mean, spread)
    return share


@njit(cache=True, error_model="numpy", fastmath=FAST, nogil=True)
def _odds(log_noise: float, agreement: float, share: _Share) -> float:
    """Log odds that noise created a pair, whatever its score."""
    return float(share.bias + _GROWTH * log_noise - _DISSENT * (agreement - 0.5))


@njit(cache=True, error_model="numpy", fastmath=FAST, nogil=True)
def _evidence(log_odds: float, log_noise: float, share: _Share) -> float:
    """Log odds, by a pair's log odds by matching, that noise created it."""
    # Even lower scores are no evidence against noise.
    value = max(log_odds, _MEAN)
    chance = (value - _MEAN) / _SPREAD
    other = (value - share.mean - _FADING * log_noise) / share.spread
    return float(np.log(share.spread / _SPREAD) + 0.5 * (other * other - chance * chance))


@njit(cache=True, error_model="numpy", fastmath=FAST, nogil=True)
def _logistic(log_odds: float) -> float:
    return float(1.0 / (1.0 + np.exp(-log_odds)))


@njit(cache=True, error_model="numpy", fastmath=FAST, nogil=True)
def _update(
    rows: Integers,
    evidence: tuple[Array, Floats, Floats],
    neighbours: Neighbours,
    share: _Share,
    found: Array,
) -> None:
    """Write the probabilities of some pairs."""
    log_odds, noise, trust = evidence
    agreement, company = neighbours
    for i in rows:
        created = 0.0
        if noise[i] > _LEAST_NOISE:
            log_noise = np.log(noise[i] / _EVEN_NOISE)
            before = _odds(log_noise, agreement[i], share)
            created = _logistic(before + _evidence(log_odds[i], log_noise, share))
        effect = noise[i] / (noise[i] + _EVEN_NOISE)
        across = trust[i] / (trust[i] + _EVEN_TRUST)
        change = _FAINT * across + _ALONG * (1.0 - across) + _CONSENT * (agreement[i] - 0.5)
        other = _logistic(_OFFSET + log_odds[i] + effect * change)
        correct = _logistic(_CORRECT + _CORRECT_IN_COMPANY * company[i])
        found[i] = (1.0 - created) * other + created * correct
