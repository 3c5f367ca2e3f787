"""Fine tuning: the part of the disparity below a pixel, from phase differences (Eqs 20, 21)."""

import dataclasses

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.records import Features, Matches
from recon.stereo.filters import WAVELENGTH_OF_WIDTH
from recon.stereo.lanes import Floats, Integers, kernel

_FINEST_WIDTH_PX = 2.0
"""Narrower filters answer to negative frequencies too: good to match with, bad to tune with."""
_VAGUE_SHARE = 0.1
"""Share of a vertical edge's information at which half of the change is taken: an edge along the
row says nothing of the disparity, and must not break a good match."""
_LARGEST_PHASE = 2.2
"""Radians; a larger difference has wrapped round, or belongs to nothing."""
_LARGEST_CHANGE_PX = 0.7
"""A larger change means that phase and position disagree; position is kept then."""
UNTUNED_SIGMA_PX = 0.4
"""Of a disparity that is known to the pixel only."""
_SMALLEST_SIGMA_PX = 0.03
# Variance of the tuned disparity, fitted to the errors of recorded pairs with truth (Venus,
# Sawtooth, Cones, Map; the others confirm it): it grows with the discord of the channels, in
# pixels, and as trust goes.
_DISCORD_WEIGHT = 0.26
_VAGUENESS_WEIGHT = 0.14

Array = NDArray[np.float64]


def refine(matches: Matches, left: Features, right: Features) -> Matches:
    """Tune whole-pixel disparities by the phase that is left over at the matched pixels.

    With responses whose phase grows along the row, ``d = delta + (phi_right - phi_left) / k``,
    where k is the local frequency along the row, measured in both pictures. All scales and
    orientations are taken together by weighted least squares. Pairs that have a sigma are tuned
    already, and left as they are.
    """
    rows = np.flatnonzero(np.isnan(matches.sigma_px))
    # In the order of the picture, as memory is slow to jump about in.
    rows = rows[np.argsort(matches.points_px[rows] @ (1, left.grey.shape[1]))]
    tuned = np.flatnonzero(np.asarray(left.widths_px) >= _FINEST_WIDTH_PX)
    if not rows.size:
        return matches
    nominal = 2 * np.pi / (WAVELENGTH_OF_WIDTH * np.asarray(left.widths_px))
    u, v = matches.points_px[rows].astype(np.int64).T
    delta = np.rint(matches.disparity_px[rows]).astype(np.int64)
    disparity, sigma = matches.disparity_px.copy(), matches.sigma_px.copy()
    change, sigma[rows] = _tune(left.planes, right.planes, tuned, nominal, (u, v, u - delta))
    disparity[rows] = delta + change
    return dataclasses.replace(matches, disparity_px=disparity, sigma_px=sigma)


@njit(cache=True, error_model="numpy")
def _tune(
    left: Floats,
    right: Floats,
    scales: Integers,
    nominal: Array,
    pixels: tuple[Integers, Integers, Integers],
) -> tuple[Array, Array]:
    u_left, v, u_right = pixels
    change = np.empty(v.size)
    sigma = np.empty(v.size)
    sums = np.zeros(5)
    for i in range(v.size):
        sums[:] = 0.0
        for s in scales:
            here, there = left[v[i], s], right[v[i], s]
            _add_scale(here, u_left[i], there, u_right[i], nominal[s], sums)
        change[i], sigma[i] = _solve(sums)
    return change, sigma


@kernel
def _add_scale(
    here: Floats, u_here: int, there: Floats, u_there: int, nominal: float, sums: Array
) -> None:
    """Add what all orientations of one scale say; `here` and `there` are rows of responses."""
    for o in range(here.shape[0]):
        response = _response(here[o, 0], here[o, 1], u_here)
        _add_evidence(response, _response(there[o, 0], there[o, 1], u_there), nominal, sums)


@kernel
def _add_evidence(
    here: tuple[complex, complex], there: tuple[complex, complex], nominal: float, sums: Array
) -> None:
    """Add one channel to the sums of the least squares problem, unless its phase has wrapped."""
    difference = _angle(there[0] * here[0].conjugate())
    if abs(difference) > _LARGEST_PHASE:
        return
    frequency = 0.5 * _angle(here[1] + there[1])
    weight = min(_energy(here[0]), _energy(there[0]))
    sums[0] += weight * frequency**2
    sums[1] += weight * frequency * difference
    sums[2] += weight * difference**2
    sums[3] += weight * nominal**2
    sums[4] += 1


@kernel
def _solve(sums: Array) -> tuple[float, float]:
    """Change of the disparity, and its standard deviation."""
    information, moment, power, vertical, channels = sums
    if information <= 1e-6 * vertical:
        return 0.0, UNTUNED_SIGMA_PX
    share_sq = (information / vertical) ** 2
    trust = share_sq / (share_sq + _VAGUE_SHARE**2)
    change = moment / information
    if trust * abs(change) > _LARGEST_CHANGE_PX:
        return 0.0, UNTUNED_SIGMA_PX
    discord = np.sqrt(max(power - moment * change, 0.0) / information)
    discord *= channels / max(channels - 1, 1)
    variance = _DISCORD_WEIGHT * trust * discord + _VAGUENESS_WEIGHT * (1.0 - trust)
    sigma = np.sqrt(variance + _SMALLEST_SIGMA_PX**2)
    return trust * change, min(sigma, UNTUNED_SIGMA_PX)


@kernel
def _response(real: Floats, imag: Floats, u: int) -> tuple[complex, complex]:
    """Response at a pixel of a row, and its turn over the two pixels round it."""
    before, after = max(u - 1, 0), min(u + 1, real.size - 1)
    turn = complex(real[after], imag[after]) * complex(real[before], -imag[before])
    return complex(real[u], imag[u]), turn


@kernel
def _angle(z: complex) -> float:
    angle: float = np.arctan2(z.imag, z.real)
    return angle


@kernel
def _energy(z: complex) -> float:
    return z.real * z.real + z.imag * z.imag
