"""Fine tuning: the part of the disparity below a pixel, from phase differences (Eqs 20, 21)."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from recon.records import Features, Matches
from recon.stereo.filters import WAVELENGTH_OF_WIDTH

_FINEST_WIDTH_PX = 2.0
"""Narrower filters answer to negative frequencies too: good to match with, bad to tune with."""
_PRIOR = 0.1
"""Weight of "no change", as a share of the information a vertical edge would give: an edge along
the row says nothing of the disparity, and must not break a good match."""
_LARGEST_PHASE = 2.2
"""Radians; a larger difference has wrapped round, or belongs to nothing."""
_LARGEST_CHANGE_PX = 0.7
"""A larger change means that phase and position disagree; position is kept then."""

Array = NDArray[np.float64]


def refine(matches: Matches, left: Features, right: Features) -> Matches:
    """Tune whole-pixel disparities by the phase that is left over at the matched pixels.

    With responses whose phase grows along the row, ``d = delta + (phi_right - phi_left) / k``,
    where k is the local frequency along the row, measured in both pictures. All scales and
    orientations are taken together by weighted least squares.
    """
    tuned = np.asarray(left.widths_px) >= _FINEST_WIDTH_PX
    if not len(matches) or not tuned.any():
        return matches
    u, v = matches.points_px.astype(np.int64).T
    disparity = np.rint(matches.disparity_px).astype(np.int64)
    at_left, slope_left = _response(left, tuned, u, v)
    at_right, slope_right = _response(right, tuned, u - disparity, v)
    difference = np.angle(at_right * at_left.conj())
    frequency = np.angle(slope_left + slope_right) / 2
    weight = np.minimum(np.abs(at_left), np.abs(at_right)) ** 2
    weight[np.abs(difference) > _LARGEST_PHASE] = 0
    nominal = 2 * np.pi / (WAVELENGTH_OF_WIDTH * np.asarray(left.widths_px)[tuned])
    prior = _PRIOR * (weight * np.repeat(nominal, len(weight) // len(nominal))[:, None] ** 2).sum(0)
    information = (weight * frequency**2).sum(0) + prior
    change = (weight * frequency * difference).sum(0) / np.maximum(information, 1e-9)
    change[np.abs(change) > _LARGEST_CHANGE_PX] = 0
    return dataclasses.replace(matches, disparity_px=disparity + change)


def _response(
    features: Features, tuned: NDArray[np.bool_], u: NDArray[np.int64], v: NDArray[np.int64]
) -> tuple[NDArray[np.complex64], NDArray[np.complex64]]:
    """Responses (C, M) at some pixels, and their growth over the two pixels round them."""
    planes = features.planes[tuned]
    planes = planes.reshape(-1, 2, *features.grey.shape)
    last = features.grey.shape[1] - 1

    def at(column: NDArray[np.int64]) -> NDArray[np.complex64]:
        column = np.clip(column, 0, last)
        response: NDArray[np.complex64] = planes[:, 0, v, column] + 1j * planes[:, 1, v, column]
        return response

    return at(u), at(u + 1) * at(u - 1).conj()
