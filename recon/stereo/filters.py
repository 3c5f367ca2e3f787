"""Steerable quadrature filters: fourth derivative of a Gaussian and its Hilbert transform.

A filter of width s is Eq 11 read in unit coordinates u = pixel / s; its wavelength is 2.22 s.
Coarse scales are computed with the taps spread over a smoothed image: every pixel gets the answer
that a pyramid would give at it, and nothing has to be interpolated.
"""

import math
from functools import cache

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float32]

WAVELENGTH_OF_WIDTH = 2.22
"""Wavelength of the strongest response, in widths."""
ORIENTATIONS = 6
"""Sampled directions over half a turn; the fewest that leave the second harmonic unaliased."""
DESCRIPTORS = 3
"""Every second of them describes a pixel in matching: 0, 60 and 120 degrees."""

_SUPPORT = 3.0
"""Half support in widths; the filter has fallen to 1e-3 there."""
_SPREAD_WIDTH = 2.0
"""Narrowest width, in steps of the lattice, of a filter on a spread-out one: below it the odd
filter answers to negative frequencies too, and phase does not grow evenly with the pixel."""
_G = 1.246
_H = 0.3975
_H3 = -2.982 / _H
_H1 = 2.858 / _H

# Names of the rows of `kernels`.
_P0, _P1, _P2, _P3, _P4, _H5, _H4, _C1, _C2, _RP0, _RP1 = range(11)
_VERTICAL = 9
# Each product of a vertical and a horizontal factor, and the basis filter it adds to.
_PRODUCTS = np.array(
    [
        (_P0, _P4, 0), (_P1, _P3, 1), (_P2, _P2, 2), (_P3, _P1, 3), (_P4, _P0, 4),
        (_P0, _H5, 5), (_P1, _H4, 6), (_C2, _C1, 7), (_P0, _RP1, 7), (_C1, _C2, 8),
        (_P1, _RP0, 8), (_H4, _P1, 9), (_H5, _P0, 10),
    ]
)  # fmt: skip


def level(width_px: float) -> int:
    """How often the lattice of a filter is doubled."""
    return max(0, math.floor(math.log2(width_px / _SPREAD_WIDTH)))


@cache
def kernels(width_px: float) -> Array:
    """(11, T) one-dimensional factors, each sampled at u = k / width.

    The exact separable form of Eqs 11 to 13: G by products of p0..p4; H by h5, h4, c1, c2 and p0,
    p1, its two middle terms being sums of two products (r p1 p0 is the second).
    """
    radius = int(_SUPPORT * width_px)
    u = np.arange(-radius, radius + 1) / width_px
    gauss = np.exp(-u * u)
    rest = 0.2 * _H1 - 0.03 * _H3**2
    p2 = (u**2 - 0.5) * gauss
    p4 = (u**4 - 3.0 * u**2 + 0.75) * gauss
    factors = [
        gauss,
        u * gauss,
        p2 - gauss * p2.sum() / gauss.sum(),  # truncation leaves a mean, which would be a phase
        (u**3 - 1.5 * u) * gauss,
        p4 - gauss * p4.sum() / gauss.sum(),
        (u**5 + _H3 * u**3 + _H1 * u) * gauss,
        (u**4 + 0.6 * _H3 * u**2 + 0.2 * _H1) * gauss,
        (u**3 + 0.3 * _H3 * u) * gauss,
        (u**2 + 0.1 * _H3) * gauss,
        rest * gauss,
        rest * u * gauss,
    ]
    return np.array(factors, dtype=np.float32) / np.float32(width_px)


@cache
def steering() -> Array:
    """(ORIENTATIONS, 11) weights of the basis: five of G, then six of H (Eqs 12, 13)."""
    theta = np.arange(ORIENTATIONS) * np.pi / ORIENTATIONS
    c, s = np.cos(theta), np.sin(theta)
    even = [_G * math.comb(4, k) * c ** (4 - k) * s**k for k in range(5)]
    odd = [_H * math.comb(5, k) * c ** (5 - k) * s**k for k in range(6)]
    return np.array(even + odd, dtype=np.float32).T.copy()


def respond(grey: Array, width_px: float, planes: Array, harmonics: Array) -> None:
    """Filter an image at one width.

    Parameters
    ----------
    grey : (H, W) float32
    width_px : float
    planes : (DESCRIPTORS, 2, H, W) float32
        Written: real and imaginary part of the response ``G - jH`` by correlation, whose phase
        grows with the pixel, at 0, 60 and 120 degrees.
    harmonics : (3, H, W) float32
        Added to: mean over the direction of the squared modulus, and its second harmonic
        (cosine, sine).
    """
    step = 2 ** level(width_px)
    taps = kernels(width_px / step)
    pad = step * (taps.shape[1] // 2)
    smooth = _smoothed(grey, level(width_px))
    padded = cv2.copyMakeBorder(smooth, pad, pad, pad, pad, cv2.BORDER_REPLICATE)
    _filter(padded, taps, step, steering(), planes, harmonics)


def _smoothed(grey: Array, level: int) -> Array:
    """The image smoothed for a lattice that is doubled `level` times."""
    kernel = np.ones(1)
    for doubling in range(level):
        spread = np.zeros(4 * 2**doubling + 1)
        spread[:: 2**doubling] = (1 / 16, 4 / 16, 6 / 16, 4 / 16, 1 / 16)
        kernel = np.convolve(kernel, spread)
    if level == 0:
        return grey
    smooth: Array = cv2.sepFilter2D(
        grey, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_REPLICATE
    )
    return smooth


@njit(cache=True, fastmath={"contract", "nsz"}, error_model="numpy")
def _filter(
    padded: Array, taps: Array, step: int, weights: Array, planes: Array, harmonics: Array
) -> None:
    height, width = planes.shape[2:]
    columns = np.empty((_VERTICAL, padded.shape[1]), np.float32)
    basis = np.empty((11, width), np.float32)
    for y in range(height):
        _filter_columns(padded, taps, step, y, columns)
        _filter_row(columns, taps, step, basis)
        _steer(basis, weights, planes[:, :, y], harmonics[:, y])


@njit(cache=True, fastmath={"contract", "nsz"}, error_model="numpy")
def _filter_columns(padded: Array, taps: Array, step: int, y: int, columns: Array) -> None:
    columns[:] = 0.0
    for k in range(taps.shape[1]):
        row = padded[y + k * step]
        for i in range(columns.shape[0]):
            weight = taps[i, k]
            out = columns[i]
            for x in range(row.size):
                out[x] += weight * row[x]


@njit(cache=True, fastmath={"contract", "nsz"}, error_model="numpy")
def _filter_row(columns: Array, taps: Array, step: int, basis: Array) -> None:
    basis[:] = 0.0
    width = basis.shape[1]
    for i in range(_PRODUCTS.shape[0]):
        vertical, horizontal, target = _PRODUCTS[i]
        out = basis[target]
        for k in range(taps.shape[1]):
            weight = taps[horizontal, k]
            shifted = columns[vertical, k * step : k * step + width]
            for x in range(width):
                out[x] += weight * shifted[x]


@njit(cache=True, fastmath={"contract", "nsz"}, error_model="numpy")
def _steer(basis: Array, weights: Array, planes: Array, harmonics: Array) -> None:
    width = basis.shape[1]
    real = np.empty(width, np.float32)
    imag = np.empty(width, np.float32)
    for i in range(weights.shape[0]):
        real[:] = 0.0
        imag[:] = 0.0
        for k in range(5):
            weight = weights[i, k]
            for x in range(width):
                real[x] += weight * basis[k, x]
        for k in range(5, 11):
            weight = weights[i, k]
            for x in range(width):
                imag[x] -= weight * basis[k, x]
        angle = 2.0 * np.pi * i / weights.shape[0]
        share = np.float32(1.0 / weights.shape[0])
        c = np.float32(2.0 * np.cos(angle)) * share
        s = np.float32(2.0 * np.sin(angle)) * share
        for x in range(width):
            energy = real[x] * real[x] + imag[x] * imag[x]
            harmonics[0, x] += share * energy
            harmonics[1, x] += c * energy
            harmonics[2, x] += s * energy
        if i % 2 == 0:
            planes[i // 2, 0] = real
            planes[i // 2, 1] = imag
