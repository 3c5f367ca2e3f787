"""Sub-pixel refinement of the disparity, from phase differences (Eqs 20, 21)."""

import dataclasses
from functools import partial
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.camera import TYPICAL_RESIDUAL_PX
from recon.errors import InputError
from recon.records import Features, Matches, check_alike
from recon.stereo.filters import WAVELENGTH_OF_WIDTH
from recon.stereo.kernels.angle import angles
from recon.stereo.kernels.simd import NUM_LANES, Floats, Integers, kernel, load, spread, store
from recon.stereo.kernels.sorting import order
from recon.stereo.kernels.threads import bands, run
from recon.stereo.neighbours import neighbours
from recon.stereo.rectification import residual_of_rows
from recon.stereo.uncertainty import (
    Prior,
    calm_ratios,
    solve,
    white_energies,
)

Array = NDArray[np.float64]

_FINEST_WIDTH_PX = 2.0
"""Narrower filters also respond to negative frequencies: good for matching, bad for refinement."""
_LEAST_COSINE = np.float32(np.cos(2.2))
"""Minimum cosine of a phase difference; larger differences have wrapped or are meaningless."""

_LEAST_BAND = 4096
"""Minimum number of pairs per thread."""
_CHUNK = 64
"""Pairs refined at once, so that their data stays in the cache."""


def refine(
    matches: Matches,
    left: Features,
    right: Features,
    residual_px: float | None = TYPICAL_RESIDUAL_PX,
) -> Matches:
    """Refine whole-pixel disparities by the residual phase at the matched pixels.

    With responses whose phase increases along the row, ``d = delta + (phi_right - phi_left) / k``,
    where k is the local frequency along the row, measured in both images. All scales and
    orientations are combined by weighted least squares. The standard deviation follows from the
    noise of both images, the agreement of the channels, the probability of the pair and the
    residual of the rig. Pairs with a sigma are already refined and stay unchanged.

    Parameters
    ----------
    residual_px : float, optional
        See `StereoRig.residual_px`; None = as the rows of the images suggest.
    """
    check_alike(left, right)
    rows = np.flatnonzero(np.isnan(matches.sigma_px))
    u, v = matches.points_px[rows].astype(np.int64).T
    # In image order, since random memory access is slow.
    along = order(v * left.grey.shape[1] + u)
    rows, u, v = rows[along], u[along], v[along]
    delta = np.rint(matches.disparity_px[rows]).astype(np.int64)
    _check_inside(left.grey.shape, u, v, u - delta)
    widths = np.asarray(left.widths_px, dtype=np.float32)
    scales = np.flatnonzero(widths >= _FINEST_WIDTH_PX)
    nominal = np.float32(2 * np.pi / WAVELENGTH_OF_WIDTH) / widths
    last = left.grey.shape[1] - 1
    pixels = u, v, u - delta

    def sums_of(pairs: tuple[int, int]) -> Floats:
        some = tuple(column[slice(*pairs)] for column in pixels)
        found: Floats = _sum(left.planes, right.planes, scales, nominal, some, last)
        return found

    parts = run([partial(sums_of, pairs) for pairs in bands(len(rows), _LEAST_BAND)])
    sums = np.concatenate(parts, axis=1)
    white = white_energies(left, right, scales, left.grey[v, u])
    prior = Prior(
        probability=matches.probability[rows],
        is_sure=rows <= len(matches) // 2,
        neighbours=neighbours(u, v, delta, rows),
    )
    if residual_px is None:
        sure = prior.is_sure & _is_inner(left.grey.shape, *pixels)
        of_sure = tuple(column[sure] for column in pixels)
        residual_px = residual_of_rows(left.planes, right.planes, scales, of_sure)
    tuning = solve(sums, white, calm_ratios(left, right, scales), prior, residual_px)
    disparity, sigma = matches.disparity_px.copy(), matches.sigma_px.copy()
    disparity[rows] = delta + tuning.change_px
    sigma[rows] = tuning.sigma_px
    probability, is_whole = matches.probability.copy(), matches.is_whole.copy()
    probability[rows], is_whole[rows] = tuning.probability, tuning.is_whole
    return dataclasses.replace(
        matches,
        disparity_px=disparity,
        sigma_px=sigma,
        probability=probability,
        is_whole=is_whole,
    )


def _check_inside(shape: tuple[int, ...], u: Integers, v: Integers, u_right: Integers) -> None:
    """Refuse pixels outside the image, since compiled loops do not check bounds."""
    height, width = shape
    pixels = ((v, height), (u, width), (u_right, width))
    if any(x.min(initial=0) < 0 or x.max(initial=0) >= size for x, size in pixels):
        raise InputError(
            f"matches lie outside the image of {width} x {height} pixels, in the left or the right"
        )


def _is_inner(
    shape: tuple[int, ...], u: Integers, v: Integers, u_right: Integers
) -> NDArray[np.bool_]:
    """Mask of the pairs whose pixels have neighbours on all sides."""
    height, width = shape
    first, last = np.minimum(u, u_right), np.maximum(u, u_right)
    return (first > 0) & (last < width - 1) & (v > 0) & (v < height - 1)


class _Channels(NamedTuple):
    """Measurements per channel (scale and orientation) for a chunk; (C, _CHUNK)."""

    product: Floats
    """(2, C, _CHUNK) real and imaginary part of right times conjugate left response."""
    turn: Floats
    """(2, C, _CHUNK) phase rotation of the response over two pixels of the row, both images."""
    difference: Floats
    """Residual phase."""
    double_frequency: Floats
    """Local frequency along the row, in radians for two pixels."""
    weight: Floats
    """Energy of the weaker response; 0 where the phase has wrapped or is meaningless."""
    is_counted: Floats
    """1, or 0 where the weight is 0."""


@njit(cache=True, error_model="numpy", nogil=True)
def _sum(
    left: Floats,
    right: Floats,
    scales: Integers,
    nominal: Floats,
    pixels: tuple[Integers, Integers, Integers],
    last: int,
) -> Floats:
    """Sums (3 S + 2, N) of the least squares problem of each pair; see `solve`."""
    num_pairs = pixels[0].size
    num_channels = scales.size * left.shape[2]
    both, single = (2, num_channels, _CHUNK), (num_channels, _CHUNK)
    channels = _Channels(
        np.zeros(both, np.float32), np.zeros(both, np.float32), np.zeros(single, np.float32),
        np.zeros(single, np.float32), np.zeros(single, np.float32), np.zeros(single, np.float32),
    )  # fmt: skip
    chunk_sums = np.zeros((3 * scales.size + 2, _CHUNK), np.float32)
    sums = np.zeros((3 * scales.size + 2, num_pairs), np.float32)
    if num_channels:
        for first in range(0, num_pairs, _CHUNK):
            chunk = slice(first, min(first + _CHUNK, num_pairs))
            places = pixels[0][chunk], pixels[1][chunk], pixels[2][chunk]
            _compare(left, right, scales, places, channels, last)
            _add_up(channels, scales, nominal, chunk_sums)
            sums[:, chunk] = chunk_sums[:, : chunk.stop - chunk.start]
    return sums


@kernel
def _compare(
    left: Floats,
    right: Floats,
    scales: Integers,
    pixels: tuple[Integers, Integers, Integers],
    channels: _Channels,
    last: int,
) -> None:
    """Write the measurements of some pairs, except the angles; `last` is the last column."""
    u_left, v, u_right = pixels
    for i in range(v.size):
        for s in range(scales.size):
            here, there = left[v[i], scales[s]], right[v[i], scales[s]]
            for o in range(here.shape[0]):
                place = s * here.shape[0] + o, i
                _compare_channel(here[o], u_left[i], there[o], u_right[i], channels, place, last)


@kernel
def _compare_channel(
    here: Floats,
    u_here: int,
    there: Floats,
    u_there: int,
    channels: _Channels,
    place: tuple[int, int],
    last: int,
) -> None:
    c, i = place
    real, imag = _turn(here, u_here, there, u_there)
    energy_here, _ = _turn(here, u_here, here, u_here)
    energy_there, _ = _turn(there, u_there, there, u_there)
    is_counted = real >= _LEAST_COSINE * np.sqrt(energy_here * energy_there)
    channels.product[0, c, i] = real
    channels.product[1, c, i] = imag
    channels.is_counted[c, i] = np.float32(is_counted)
    channels.weight[c, i] = np.float32(is_counted) * min(energy_here, energy_there)
    before, after = max(u_here - 1, 0), min(u_here + 1, last)
    real, imag = _turn(here, before, here, after)
    before, after = max(u_there - 1, 0), min(u_there + 1, last)
    real_there, imag_there = _turn(there, before, there, after)
    channels.turn[0, c, i] = real + real_there
    channels.turn[1, c, i] = imag + imag_there


@kernel
def _turn(a: Floats, u: int, b: Floats, w: int) -> tuple[float, float]:
    """Response of one row's pixel times the conjugate of another's."""
    # Unsigned indices avoid the check for negative ones.
    u_a, u_b = np.uint64(u), np.uint64(w)
    real = b[0, u_b] * a[0, u_a] + b[1, u_b] * a[1, u_a]
    imag = b[1, u_b] * a[0, u_a] - b[0, u_b] * a[1, u_a]
    return real, imag


@kernel
def _add_up(channels: _Channels, scales: Integers, nominal: Floats, sums: Floats) -> None:
    """Write the sums (3 S + 2, _CHUNK) of the least squares problem of each pair."""
    difference, double_frequency = channels.difference, channels.double_frequency
    num_channels = len(difference)
    directions = num_channels // scales.size
    for c in range(num_channels):
        angles(channels.product[0, c], channels.product[1, c], difference[c])
        angles(channels.turn[0, c], channels.turn[1, c], double_frequency[c])
    for i in range(0, _CHUNK, NUM_LANES):
        vertical = count = spread(0.0)
        for s in range(scales.size):
            k = nominal[scales[s]]
            information = moment = power = energy = spread(0.0)
            for c in range(s * directions, (s + 1) * directions):
                weight, rest = load(channels.weight[c], i), load(difference[c], i)
                frequency = 0.5 * load(double_frequency[c], i)
                information += weight * frequency * frequency
                moment += weight * frequency * rest
                power += weight * rest * rest
                energy += weight
                count += load(channels.is_counted[c], i)
            store(sums[3 * s], i, information)
            store(sums[3 * s + 1], i, moment)
            store(sums[3 * s + 2], i, power)
            vertical += k * k * energy
        store(sums[3 * scales.size], i, vertical)
        store(sums[3 * scales.size + 1], i, count)
