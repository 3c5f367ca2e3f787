"""Estimation of image noise from one image (Immerkaer 1996), by grey level and by scale.

Texture only adds to the filter response of noise, so the calmest blocks of an image reveal its
noise.
"""

from functools import cache
from itertools import accumulate, pairwise

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.records import ImageNoise
from recon.stereo import filters
from recon.stereo.harmonics import DESCRIPTORS
from recon.stereo.kernels.simd import FAST, NUM_LANES, Floats, kernel, load, spread, total

Array = NDArray[np.float64]

ROUNDING_VARIANCE = 1.0 / 12.0
"""Variance of rounding to integer grey levels."""
_BLOCK_PX = 16
_CALM_SHARE = 0.15
"""Quantile of the blocks' energies that is attributed to noise."""
_CALM_FACTOR = 1.10**2
"""True variance of white noise, relative to that quantile over blocks of 256 pixels."""
_DARKEST, _BRIGHTEST = 5.0, 250.0
"""Mean grey levels beyond which a block is saturated and uninformative."""
_GREYS = np.arange(256.0)
_NUM_GREYS = 4
"""Number of equally large groups of blocks, by grey level."""
_LEAST_BLOCKS = 16
"""Minimum number of blocks per group; smaller images have fewer groups."""
_ROW_STEP = 4
"""Row step used for the energy of a scale."""
_STEP_MARGIN = 1.6
_MODULUS_OF_ENERGY = 1.64
"""Mean square modulus of noise, relative to the sum of the scales' energies: it is measured along
the strongest direction."""


def estimate(grey: NDArray[np.uint8], planes: Floats, widths_px: tuple[float, ...]) -> ImageNoise:
    """Noise of an image (H, W), whose filter responses are `planes`.

    Parameters
    ----------
    grey : (H, W) uint8
    planes : (H, S, O, 2, W') float32
        See `Features.planes`.
    widths_px : (S,) widths of the filters
    """
    means, energies = _usable_blocks(grey)
    variance = _calm(energies)
    by_scale = np.array([
        _calm(_scale_energies(planes, s, grey.shape[1], _BLOCK_PX)) / gain(width)
        for s, width in enumerate(widths_px)
    ])  # fmt: skip
    return ImageNoise(
        level=float(np.sqrt(variance)),
        by_grey=np.sqrt(_by_grey(means, energies)).astype(np.float32),
        by_scale=np.sqrt(np.maximum(by_scale, variance)).astype(np.float32),
    )


def noise_level(grey: NDArray[np.uint8]) -> float:
    """Standard deviation of the noise of an image (H, W), in grey levels."""
    return float(np.sqrt(_calm(_usable_blocks(grey)[1])))


def _usable_blocks(grey: NDArray[np.uint8]) -> tuple[Array, Array]:
    """Mean grey level and energy of the unsaturated blocks; of all blocks if there are none."""
    means, energies = _block_energies(grey, _BLOCK_PX)
    usable = (means >= _DARKEST) & (means <= _BRIGHTEST)
    return (means[usable], energies[usable]) if usable.any() else (means, energies)


@cache
def gain(width_px: float) -> float:
    """Mean energy of the response of filters of a width to white noise of variance 1."""
    side = 16 * int(np.ceil(width_px)) + 1
    impulse = np.zeros((side, side), np.uint8)
    impulse[side // 2, side // 2] = 255
    planes = filters.respond(impulse, (width_px,)).planes[..., :side]
    return float((planes.astype(np.float64) ** 2).sum()) / (DESCRIPTORS * 255.0**2)


def floor_modulus(noise: ImageNoise, widths_px: tuple[float, ...]) -> float:
    """The modulus below which an edge is uninformative: that of noise or of a one-level step.

    Rounding creates such steps in a smooth sky or wall.
    """
    energy = sum(gain(width) for width in widths_px)
    random = noise.level * float(np.sqrt(_MODULUS_OF_ENERGY * energy))
    return max(random, _STEP_MARGIN * step_modulus(widths_px))


@cache
def step_modulus(widths_px: tuple[float, ...]) -> float:
    """Largest modulus over all scales of a vertical step of one grey level."""
    side = 16 * int(np.ceil(max(widths_px)))
    step = np.zeros((3, 2 * side), np.uint8)
    step[:, side:] = 255
    return float(filters.respond(step, widths_px).modulus.max()) / 255.0


def _calm(energies: Array) -> float:
    """Variance of white noise, from the energies of blocks."""
    rank = int(_CALM_SHARE * (len(energies) - 1)) if len(energies) else 0
    lowest = float(np.partition(energies, rank)[rank]) if len(energies) else 0.0
    return max(_CALM_FACTOR * lowest, ROUNDING_VARIANCE)


def _by_grey(means: Array, energies: Array) -> Array:
    """(256,) variance by grey level, interpolated between groups of blocks.

    Sensor noise does not decrease with the light, nor does it grow faster than the light: a group
    that violates this has texture, and is limited by the others.
    """
    num = max(1, min(_NUM_GREYS, len(means) // _LEAST_BLOCKS))
    if num == 1:
        return np.full(256, _calm(energies))
    order = np.argsort(means, kind="stable")
    means, energies = means[order], energies[order]
    edges = [len(order) * k // num for k in range(num + 1)]
    groups = [slice(first, end) for first, end in pairwise(edges)]
    sizes = [group.stop - group.start for group in groups]
    greys = np.maximum(np.add.reduceat(means, edges[:-1]) / sizes, _DARKEST).tolist()
    variances = [_calm(energies[group]) for group in groups]
    # Pure shot noise has a variance proportional to the light.
    steepest = accumulate((v / grey for v, grey in zip(variances, greys, strict=True)), min)
    limited = [slope * grey for slope, grey in zip(steepest, greys, strict=True)]
    flattest = [*accumulate(reversed(variances), min)][::-1]
    limited = [max(min(pair), ROUNDING_VARIANCE) for pair in zip(limited, flattest, strict=True)]
    between: Array = np.interp(_GREYS, greys, limited)
    return between


@njit(cache=True, error_model="numpy", fastmath=FAST, nogil=True)
def _block_energies(grey: NDArray[np.uint8], side: int) -> tuple[Array, Array]:
    """Mean grey level of each block, and mean square of its second differences in x and y, / 36.

    For white noise the latter is its variance. Every second row is enough.
    """
    height, width = grey.shape
    rows, columns = max(0, height - 2) // side, max(0, width - 2) // side
    means, energies = np.zeros((rows, columns)), np.zeros((rows, columns))
    bent, light = np.empty(width, np.float32), np.empty(width, np.float32)
    for v in range(0, rows * side, 2):
        _bend(grey[v], grey[v + 1], grey[v + 2], bent, light)
        for b in range(columns):
            energy, sum_of_light = _block_sums(bent, light, b * side, side)
            energies[v // side, b] += energy / (18.0 * side * side)
            means[v // side, b] += sum_of_light / (0.5 * side * side)
    return means.reshape(-1), energies.reshape(-1)


@kernel
def _bend(
    above: NDArray[np.uint8],
    middle: NDArray[np.uint8],
    below: NDArray[np.uint8],
    bent: Floats,
    light: Floats,
) -> None:
    """Write the second differences between three rows, and the grey levels of the middle one."""
    for u in range(bent.size):
        light[u] = np.float32(middle[u])
        bent[u] = np.float32(above[u]) - np.float32(2) * light[u] + np.float32(below[u])


@kernel
def _block_sums(bent: Floats, light: Floats, start: int, side: int) -> tuple[float, float]:
    """Sums of squared second differences along a row, and of grey levels, of some columns."""
    energy = together = spread(0.0)
    for u in range(start, start + side, NUM_LANES):
        middle = load(bent, u + 1)
        difference = load(bent, u) - (middle + middle) + load(bent, u + 2)
        energy += difference * difference
        together += load(light, u + 1)
    return total(energy), total(together)


@njit(cache=True, error_model="numpy", fastmath=FAST, nogil=True)
def _scale_energies(planes: Floats, scale: int, width: int, side: int) -> Array:
    """Mean energy of one scale's responses in each block, over all directions."""
    height, _, directions, _, _ = planes.shape
    rows, columns = height // side, width // side
    energies = np.zeros((rows, columns))
    count = directions * side * (side // _ROW_STEP)
    for v in range(0, rows * side, _ROW_STEP):
        for o in range(directions):
            _add_energy(planes[v, scale, o], side, count, energies[v // side])
    return energies.reshape(-1)


@kernel
def _add_energy(response: Floats, side: int, count: int, energies: Array) -> None:
    """Add the mean energies of a row's responses (2, W') to its blocks'."""
    real, imag = response[0], response[1]
    for b in range(energies.size):
        energy = spread(0.0)
        for u in range(b * side, (b + 1) * side, NUM_LANES):
            re, im = load(real, u), load(imag, u)
            energy += re * re + im * im
        energies[b] += total(energy) / count
