"""Conversion of times to seconds from any unit."""

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError

Array = NDArray[np.float64]

FACTORS = (1.0, 1e-3, 1e-6, 1e-9)
"""Seconds, milliseconds, microseconds, nanoseconds."""
EPOCH_S = (5e8, 5e9)
"""Plausible seconds since 1970: after 1985."""
LONGEST_STEP = 10.0
"""A longer time between frames indicates another unit."""
USUAL_STEP_S = 0.1


def in_seconds(stamps: Array) -> Array:
    """Times (N,) in seconds; the unit follows from their size since 1970, else from their step."""
    return stamps * _factor(stamps)


def _factor(stamps: Array) -> float:
    if not len(stamps) or _is_step(stamps):
        return 1.0
    since_1970 = [f for f in FACTORS if EPOCH_S[0] < stamps[0] * f < EPOCH_S[1]]
    if since_1970 or len(stamps) < 2:
        return since_1970[0] if since_1970 else 1.0
    step = float(np.median(np.diff(stamps)))
    return min(FACTORS, key=lambda factor: abs(np.log10(step * factor / USUAL_STEP_S)))


def _is_step(stamps: Array) -> bool:
    """True if the steps of the times are plausible in seconds."""
    return len(stamps) > 1 and float(np.median(np.diff(stamps))) <= LONGEST_STEP


def matched(stamps: Array, wanted: Array, name: str) -> Array:
    """Times (N,) converted to the unit in which they overlap with `wanted` (M,) seconds.

    Raises
    ------
    InputError
        If no unit makes them overlap.
    """
    for factor in (*FACTORS, *(1.0 / factor for factor in FACTORS[1:])):
        scaled = stamps * factor
        if scaled[0] <= wanted[-1] + USUAL_STEP_S and scaled[-1] >= wanted[0] - USUAL_STEP_S:
            return scaled
    raise InputError(
        f"{name} are from {stamps[0]:.6f} to {stamps[-1]:.6f} s and the images from "
        f"{wanted[0]:.6f} to {wanted[-1]:.6f} s, but overlapping times are needed"
    )
