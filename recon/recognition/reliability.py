"""Reliability of probabilities: how often statements with a probability are right."""

import numpy as np
from numpy.typing import ArrayLike

NUM_BINS = 10
"""Number of bins, of equal width."""


def calibration_error(probability: ArrayLike, is_right: ArrayLike) -> float:
    """Expected calibration error: mean gap between probability and share of correct ones, by bins.

    Parameters
    ----------
    probability : (N,) array_like
        0 to 1.
    is_right : (N,) array_like of bool

    Returns
    -------
    error : float
        0 for perfectly calibrated probabilities; NaN if there are none.
    """
    chance, right = np.asarray(probability, dtype=np.float64), np.asarray(is_right, dtype=bool)
    if not len(chance):
        return float("nan")
    own = np.minimum((chance * NUM_BINS).astype(int), NUM_BINS - 1)
    gaps = np.bincount(own, chance, NUM_BINS) - np.bincount(own, right, NUM_BINS)
    return float(np.abs(gaps).sum() / len(chance))
