"""Steerable quadrature filters: fourth derivative of a Gaussian and its Hilbert transform.

A filter of width s is Eq 11 read in unit coordinates u = pixel / s; its wavelength is 2.22 s.
Coarse scales are computed with the taps spread over a smoothed image: every pixel gets the answer
that a pyramid would give at it, and nothing has to be interpolated.
"""

import math
from functools import cache
from math import comb
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.sums import FAST, Integers, filled, kernel, weighted_sum

Array = NDArray[np.float32]

WAVELENGTH_OF_WIDTH = 2.22
"""Wavelength of the strongest response, in widths."""
DESCRIPTORS = 3
"""Directions that describe a pixel in matching: 0, 60 and 120 degrees."""

_TILE = 256
"""Columns that are filtered at once, so that the rows in work stay in the fastest memory."""
_SUPPORT = 2.75
"""Half support in widths; the filter has fallen to 3e-3 there."""
_SPREAD_WIDTH = 2.0
"""Narrowest width, in steps of the lattice, of a filter on a spread-out one: below it the odd
filter answers to negative frequencies too, and phase does not grow evenly with the pixel."""
_G = 1.246
_H = 0.3975
_H3 = -2.982 / _H
_H1 = 2.858 / _H

# Names of the rows of `kernels`; the first nine are also applied along columns.
_P0, _P1, _P2, _P3, _P4, _H5, _H4, _C1, _C2, _RP0, _RP1 = range(11)
_COLUMN_KERNELS = 9
# Products of a column and a row kernel that make up each basis filter: five of G, six of H.
_PRODUCTS = (
    ((_P0, _P4),), ((_P1, _P3),), ((_P2, _P2),), ((_P3, _P1),), ((_P4, _P0),),
    ((_P0, _H5),), ((_P1, _H4),), ((_C2, _C1), (_P0, _RP1)), ((_C1, _C2), (_P1, _RP0)),
    ((_H4, _P1),), ((_H5, _P0),),
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


_Numbers = tuple[np.float32, ...]


class _Steering(NamedTuple):
    """How the basis makes responses; first index 0 for G's basis filters, 1 for H's.

    Tuples, so that the compiler sees numbers and no memory that might change.
    """

    weights: tuple[tuple[_Numbers, ...], ...]
    """(2, DESCRIPTORS, 6) of the descriptors' real and imaginary parts (Eqs 12, 13)."""
    forms: tuple[tuple[_Numbers, ...], ...]
    """(2, 3, 21) quadratic forms, the upper triangles: mean energy over all directions, and the
    cosine and sine of its second harmonic. In mean and cosine, rows of the basis meet only where
    the sum of their numbers is even, in the sine only where it is odd."""


@cache
def steering() -> _Steering:
    """Weights of the directions 0, 60 and 120 degrees, and the energy's harmonics in closed form.

    Twelve directions are enough for exact sums: the energy is a polynomial of degree 10 in the
    direction's cosine and sine.
    """
    theta = np.arange(12) * np.pi / 12
    c, s = np.cos(theta), np.sin(theta)
    weights = np.zeros((2, 12, 6))
    weights[0, :, :5] = np.transpose([_G * comb(4, k) * c ** (4 - k) * s**k for k in range(5)])
    weights[1] = np.transpose([-_H * comb(5, k) * c ** (5 - k) * s**k for k in range(6)])
    harmonics = np.array([np.ones(12), 2 * np.cos(2 * theta), 2 * np.sin(2 * theta)]) / 12
    forms = np.einsum("ht,pti,ptj->phij", harmonics, weights, weights)
    forms = (2 * forms - forms * np.eye(6))[..., *np.triu_indices(6)]
    return _Steering(_as_tuples(weights[:, ::4]), _as_tuples(forms))


def _as_tuples(numbers: NDArray[np.float64]) -> tuple[tuple[_Numbers, ...], ...]:
    """The numbers of a (K, L, M) array."""
    return tuple(tuple(tuple(np.float32(x) for x in row) for row in part) for part in numbers)


class _Lattice(NamedTuple):
    """A smoothed picture, and a filter's taps as weighted sums of stretches of it."""

    picture: Array
    """(H + 2 P, W + 2 P) with a margin for the filter."""
    margin: int
    """P"""
    stride: int
    """From one of a tile's nine column sums to the next."""
    column_starts: Integers
    """(K,) from the first row of a window, in the flat picture."""
    column_weights: Array
    """(9, K)"""
    row_starts: Integers
    """(11, K') in the nine column sums of a tile's row, one after the other."""
    row_weights: Array
    """(11, K')"""


def _lattice(grey: Array, width_px: float) -> _Lattice:
    step = 2 ** level(width_px)
    taps = kernels(width_px / step)
    size = taps.shape[1]
    pad = step * (size // 2)
    smooth = _smoothed(grey, level(width_px))
    picture = cv2.copyMakeBorder(smooth, pad, pad, pad, pad, cv2.BORDER_REPLICATE)
    stride = _TILE + 2 * pad
    column_starts = np.zeros(filled(size), np.int64)
    column_starts[:size] = np.arange(size) * step * picture.shape[1]
    column_weights = np.zeros((_COLUMN_KERNELS, filled(size)), np.float32)
    column_weights[:, :size] = taps[:_COLUMN_KERNELS]
    row_starts = np.zeros((len(_PRODUCTS), filled(2 * size)), np.int64)
    row_weights = np.zeros(row_starts.shape, np.float32)
    for i, products in enumerate(_PRODUCTS):
        for j, (column, row) in enumerate(products):
            part = slice(j * size, (j + 1) * size)
            row_starts[i, part] = column * stride + np.arange(size) * step
            row_weights[i, part] = taps[row]
    return _Lattice(picture, pad, stride, column_starts, column_weights, row_starts, row_weights)


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


class Responses(NamedTuple):
    """What the filters answer to a picture."""

    planes: Array
    """(S, DESCRIPTORS, 2, H, W) real and imaginary part of the response ``G - jH`` by correlation,
    whose phase grows with the pixel, at 0, 60 and 120 degrees."""
    modulus: Array
    """(H, W) strength, all scales together, in grey levels."""
    cosine: Array
    """(H, W) with `sine` a vector whose angle is twice the direction across the edge (Eq 14)."""
    sine: Array


def respond(grey: NDArray[np.uint8], widths_px: tuple[float, ...]) -> Responses:
    """Filter an image (H, W) at all widths."""
    picture = grey.astype(np.float32)
    lattices = tuple(_lattice(picture, width) for width in widths_px)
    responses = Responses(
        np.empty((len(widths_px), DESCRIPTORS, 2, *grey.shape), np.float32),
        *(np.empty(grey.shape, np.float32) for _ in range(3)),
    )
    columns = np.empty(_COLUMN_KERNELS * max(lattice.stride for lattice in lattices), np.float32)
    _filter(lattices, steering(), columns, responses)
    return responses


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _filter(
    lattices: tuple[_Lattice, ...], steering: _Steering, columns: Array, responses: Responses
) -> None:
    height, width = responses.modulus.shape
    for first in range(0, width, _TILE):
        tile = slice(first, min(first + _TILE, width))
        basis = np.zeros((12, tile.stop - first), np.float32)
        harmonics = np.zeros((3, tile.stop - first), np.float32)
        for v in range(height):
            harmonics[:] = 0.0
            for s in range(len(lattices)):
                _filter_row(lattices[s], v, first, columns, basis)
                _describe(basis, steering, responses.planes[s], v, first)
                _add_energy(basis, steering, harmonics)
            _measure(harmonics, responses.modulus[v, tile])
            responses.cosine[v, tile] = harmonics[1]
            responses.sine[v, tile] = harmonics[2]


@kernel
def _filter_row(lattice: _Lattice, v: int, first: int, columns: Array, basis: Array) -> None:
    """Write the basis filters of a tile's row: five of G, one left empty, six of H."""
    size = basis.shape[1] + 2 * lattice.margin
    rows = lattice.picture.reshape(-1)[v * lattice.picture.shape[1] + first :]
    for i in range(_COLUMN_KERNELS):
        column = columns[i * lattice.stride :][:size]
        weighted_sum(rows, lattice.column_starts, lattice.column_weights[i], column)
    for i in range(lattice.row_weights.shape[0]):
        # Only two of the basis filters are sums of two products.
        size = lattice.row_weights.shape[1] if i in (7, 8) else lattice.column_starts.size
        starts, weights = lattice.row_starts[i, :size], lattice.row_weights[i, :size]
        weighted_sum(columns, starts, weights, basis[i if i < 5 else i + 1])


@kernel
def _measure(harmonics: Array, modulus: Array) -> None:
    """Strength of the response: an isotropic part, and what lies in one direction."""
    mean, cosine, sine = harmonics[0], harmonics[1], harmonics[2]
    for u in range(modulus.size):
        along = np.sqrt(cosine[u] * cosine[u] + sine[u] * sine[u])
        modulus[u] = np.sqrt(mean[u] + along)


@kernel
def _describe(basis: Array, steering: _Steering, planes: Array, v: int, first: int) -> None:
    """Write the descriptors (DESCRIPTORS, 2, H, W) of a stretch of row v."""
    for part in range(2):
        own = basis[6 * part : 6 * part + 6]
        for i in range(planes.shape[0]):
            # A slice of the last axis alone, or the compiler does not see neighbours in memory.
            _mix(own, steering.weights[part][i], planes[i, part, v, first : first + own.shape[1]])


@kernel
def _mix(basis: Array, w: _Numbers, out: Array) -> None:
    """Weighted sum of the six rows."""
    a, b, c, d, e, f = basis[0], basis[1], basis[2], basis[3], basis[4], basis[5]
    for i in range(out.size):
        out[i] = w[0] * a[i] + w[1] * b[i] + w[2] * c[i] + w[3] * d[i] + w[4] * e[i] + w[5] * f[i]


@kernel
def _add_energy(basis: Array, steering: _Steering, harmonics: Array) -> None:
    """Add the energy of one scale, and its second harmonic."""
    for part in range(2):
        own = basis[6 * part : 6 * part + 6]
        for k in range(2):
            _add_even(own, steering.forms[part][k], harmonics[k])
        _add_odd(own, steering.forms[part][2], harmonics[2])


@kernel
def _add_even(basis: Array, m: _Numbers, out: Array) -> None:
    """Add a quadratic form of the six rows in which odd and even rows do not meet."""
    a, b, c, d, e, f = basis[0], basis[1], basis[2], basis[3], basis[4], basis[5]
    for i in range(out.size):
        p, q, r, s, t, w = a[i], b[i], c[i], d[i], e[i], f[i]
        out[i] += p * (m[0] * p + m[2] * r + m[4] * t) + q * (m[6] * q + m[8] * s + m[10] * w)
        out[i] += r * (m[11] * r + m[13] * t) + s * (m[15] * s + m[17] * w)
        out[i] += m[18] * t * t + m[20] * w * w


@kernel
def _add_odd(basis: Array, m: _Numbers, out: Array) -> None:
    """Add a quadratic form of the six rows in which odd rows meet even ones alone."""
    a, b, c, d, e, f = basis[0], basis[1], basis[2], basis[3], basis[4], basis[5]
    for i in range(out.size):
        p, q, r, s, t, w = a[i], b[i], c[i], d[i], e[i], f[i]
        out[i] += p * (m[1] * q + m[3] * s + m[5] * w) + q * (m[7] * r + m[9] * t)
        out[i] += r * (m[12] * s + m[14] * w) + t * (m[16] * s + m[19] * w)
