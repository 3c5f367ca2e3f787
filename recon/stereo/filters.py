"""Steerable quadrature filters: fourth derivative of a Gaussian and its Hilbert transform.

A filter of width s is Eq 11 in unit coordinates u = pixel / s; its wavelength is 2.22 s. Coarse
scales are computed with dilated taps on a smoothed image: every pixel gets the response of a
pyramid, without interpolation.
"""

import math
from functools import cache
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo import harmonics
from recon.stereo.harmonics import DESCRIPTORS
from recon.stereo.kernels.memory import reused_empty
from recon.stereo.kernels.simd import (
    FAST,
    NUM_LANES,
    Floats,
    Lanes,
    filled,
    kernel,
    load,
    spread,
    store,
)

WAVELENGTH_OF_WIDTH = 2.22
"""Wavelength of the strongest response, in widths."""

_SUPPORT = 2.75
"""Half support in widths, where the filter has decayed to 3e-3."""
_SPREAD_WIDTH = 2.0
"""Minimum width, in lattice steps, of a filter on a dilated lattice: below it the odd filter also
responds to negative frequencies, and the phase is not linear in the pixel."""
_G = 1.246
_H = 0.3975
_H3 = -2.982 / _H
_H1 = 2.858 / _H

_NUM_SUMS = 7
"""Number of column sums per row of responses: with p0, p1, p2, p3, p4, h5, h4."""


def level(width_px: float) -> int:
    """Number of doublings of a filter's lattice."""
    return max(0, math.floor(math.log2(width_px / _SPREAD_WIDTH)))


class Taps(NamedTuple):
    """One-dimensional factors of the basis filters, sampled at u = k / width for k = 0, 1, ...

    The other halves are symmetric or antisymmetric. The value of an even factor at 0 is halved,
    since it is added from both sides.
    """

    columns: Floats
    """(R + 1, 6) p0, p1, p2, p3, p4, h5."""
    fourth: tuple[float, float]
    """h4 = p4 + ``fourth[0]`` p2 + ``fourth[1]`` p0."""
    rows: Floats
    """(R + 1, 13) factors along the row, in the order in which `_basis` uses them."""


@cache
def taps(width_px: float) -> Taps:
    """The exact separable form of Eqs 11 to 13.

    ``g_i = p_(4-i)(x) p_i(y)``, and ``h_i`` likewise with h5, h4, c1, c2, p1, p0, except that the
    two middle ones are ``c1(x) c2(y) + r p1(x) p0(y)`` and ``c2(x) c1(y) + r p0(x) p1(y)``; the
    column factors c1 and c2 are sums of p3 and p1, and of p2 and p0.
    """
    u = np.arange(int(_SUPPORT * width_px) + 1) / width_px
    p0 = np.exp(-u * u)
    sides = np.where(u > 0, 2.0, 1.0)

    def without_mean(factor: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
        # Truncation leaves a mean, which would bias the phase.
        mean = float(sides @ factor / (sides @ p0))
        return factor - mean * p0, mean

    p1, p3 = u * p0, (u**3 - 1.5 * u) * p0
    p2, mean_2 = without_mean((u**2 - 0.5) * p0)
    p4, mean_4 = without_mean((u**4 - 3.0 * u**2 + 0.75) * p0)
    h5 = (u**5 + _H3 * u**3 + _H1 * u) * p0
    h4 = (u**4 + 0.6 * _H3 * u**2 + 0.2 * _H1) * p0
    c1 = (u**3 + 0.3 * _H3 * u) * p0
    c2 = (u**2 + 0.1 * _H3) * p0
    rest = 0.2 * _H1 - 0.03 * _H3**2
    middle_2 = (0.5 + 0.1 * _H3 + mean_2) * c1 + rest * p1
    middle_3 = (1.5 + 0.3 * _H3) * c2 + rest * p0
    fourth_2 = 3.0 + 0.6 * _H3
    fourth_0 = 0.5 * fourth_2 - 0.75 + 0.2 * _H1 + fourth_2 * mean_2 + mean_4
    columns = np.transpose([p0, p1, p2, p3, p4, h5])
    g, h = _G / 8, -_H / 16
    rows = np.transpose([
        g * p4, h * h5, h * middle_2,  # of p0
        g * p3, h * h4, h * middle_3,  # of p1
        g * p2, h * c1,  # of p2
        g * p1, h * c2,  # of p3
        g * p0, h * p0, h * p1,  # of p4, h5 and h4
    ])  # fmt: skip
    for factors in (columns, rows):
        factors /= width_px
        factors[0] /= 2
    return Taps(columns.astype(np.float32), (fourth_2, fourth_0), rows.astype(np.float32))


class _Lattice(NamedTuple):
    """A smoothed image, and the dilated taps for it."""

    image: Floats
    """(H + 2 P, W') with a margin of P above, below and on the left, and padding on the right."""
    margin: int
    """P, a multiple of the lanes."""
    step: int
    """Pixels from tap to tap."""
    taps: Taps


def _lattice(grey: Floats, width_px: float) -> _Lattice:
    step = 2 ** level(width_px)
    factors = taps(width_px / step)
    margin = filled(step * (len(factors.columns) - 1))
    right = filled(grey.shape[1]) - grey.shape[1] + margin
    smooth = _smoothed(grey, level(width_px))
    image = cv2.copyMakeBorder(smooth, margin, margin, margin, right, cv2.BORDER_REPLICATE)
    return _Lattice(image, margin, step, factors)


def _smoothed(grey: Floats, num_doublings: int) -> Floats:
    """The image smoothed for a lattice that is doubled `num_doublings` times."""
    if num_doublings == 0:
        return grey
    blur = np.ones(1)
    for doubling in range(num_doublings):
        taps_apart = np.zeros(4 * 2**doubling + 1)
        taps_apart[:: 2**doubling] = (1 / 16, 4 / 16, 6 / 16, 4 / 16, 1 / 16)
        blur = np.convolve(blur, taps_apart)
    smooth: Floats = cv2.sepFilter2D(grey, cv2.CV_32F, blur, blur, borderType=cv2.BORDER_REPLICATE)
    return smooth


class Responses(NamedTuple):
    """Responses of the filters to an image."""

    planes: Floats
    """(H, S, DESCRIPTORS, 2, W') real and imaginary part of the response ``G - jH`` by correlation,
    whose phase increases with the pixel, at 0, 60 and 120 degrees; rows padded to whole lanes."""
    modulus: Floats
    """(H, W) strength over all scales, in grey levels."""
    cosine: Floats
    """(H, W) with `sine` a vector at twice the angle of the edge normal (Eq 14)."""
    sine: Floats


def respond(grey: NDArray[np.uint8], widths_px: tuple[float, ...]) -> Responses:
    """Filter an image (H, W) at all widths."""
    height, width = grey.shape
    image = grey.astype(np.float32)
    lattices = tuple(_lattice(image, width_px) for width_px in widths_px)
    responses = Responses(
        reused_empty((height, len(widths_px), DESCRIPTORS, 2, filled(width))),
        *(np.empty(grey.shape, np.float32) for _ in range(3)),
    )
    widest = max(lattice.image.shape[1] for lattice in lattices)
    _filter(lattices, np.empty((_NUM_SUMS, widest), np.float32), responses)
    return responses


@njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)
def _filter(lattices: tuple[_Lattice, ...], sums: Floats, responses: Responses) -> None:
    height, width = responses.modulus.shape
    energy = np.empty((3, responses.planes.shape[4]), np.float32)
    for v in range(height):
        energy[:] = 0.0
        for s in range(len(lattices)):
            _sum_columns(lattices[s], v, sums)
            _describe(lattices[s], sums, responses.planes[v, s], energy)
        harmonics.measure(energy, responses.modulus[v])
        responses.cosine[v] = energy[1, :width]
        responses.sine[v] = energy[2, :width]


@kernel
def _sum_columns(lattice: _Lattice, v: int, sums: Floats) -> None:
    """Write the sums over the columns around row v, including margins."""
    image, columns = lattice.image.reshape(-1), lattice.taps.columns
    width = lattice.image.shape[1]
    fourth_2, fourth_0 = lattice.taps.fourth
    for u in range(0, width, NUM_LANES):
        p0 = p1 = p2 = p3 = p4 = h5 = spread(0.0)
        for k in range(columns.shape[0]):
            w, gap = columns[k], k * lattice.step
            above = load(image, (v + lattice.margin - gap) * width + u)
            below = load(image, (v + lattice.margin + gap) * width + u)
            even, odd = below + above, below - above
            p0 += w[0] * even
            p1 += w[1] * odd
            p2 += w[2] * even
            p3 += w[3] * odd
            p4 += w[4] * even
            h5 += w[5] * odd
        store(sums[0], u, p0)
        store(sums[1], u, p1)
        store(sums[2], u, p2)
        store(sums[3], u, p3)
        store(sums[4], u, p4)
        store(sums[5], u, h5)
        store(sums[6], u, p4 + fourth_2 * p2 + fourth_0 * p0)


@kernel
def _describe(lattice: _Lattice, sums: Floats, planes: Floats, energy: Floats) -> None:
    """Write the descriptors (DESCRIPTORS, 2, W') of a row, and add the harmonics of its energy."""
    for u in range(0, planes.shape[2], NUM_LANES):
        g, h = _basis(sums, u + lattice.margin, lattice.step, lattice.taps.rows)
        even, odd = harmonics.of_even(g), harmonics.of_odd(h)
        harmonics.describe(even, odd, planes, u)
        harmonics.add_energy(even, odd, energy, u)


@kernel
def _fold(row: Floats, u: int, gap: int) -> tuple[Lanes, Lanes]:
    """Sum and difference of the values ahead and behind."""
    ahead, behind = load(row, u + gap), load(row, u - gap)
    return ahead + behind, ahead - behind


@kernel
def _basis(
    sums: Floats, u: int, step: int, rows: Floats
) -> tuple[tuple[Lanes, ...], tuple[Lanes, ...]]:
    """The basis filters g0..g4 and h0..h5 at some pixels of a row."""
    g0 = g1 = g2 = g3 = g4 = spread(0.0)
    h0 = h1 = h2 = h3 = h4 = h5 = spread(0.0)
    for k in range(rows.shape[0]):
        w, gap = rows[k], k * step
        even, odd = _fold(sums[0], u, gap)
        g0 += w[0] * even
        h0 += w[1] * odd
        h2 += w[2] * odd
        even, odd = _fold(sums[1], u, gap)
        g1 += w[3] * odd
        h1 += w[4] * even
        h3 += w[5] * even
        even, odd = _fold(sums[2], u, gap)
        g2 += w[6] * even
        h2 += w[7] * odd
        even, odd = _fold(sums[3], u, gap)
        g3 += w[8] * odd
        h3 += w[9] * even
        g4 += w[10] * _fold(sums[4], u, gap)[0]
        h5 += w[11] * _fold(sums[5], u, gap)[0]
        h4 += w[12] * _fold(sums[6], u, gap)[1]
    return (g0, g1, g2, g3, g4), (h0, h1, h2, h3, h4, h5)
