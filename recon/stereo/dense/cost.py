"""The cost of matching a left and a right pixel: phase, census and grey levels.

Three complementary measures: phases are invariant to contrast, the order of the levels (census) is
invariant to gain, levels and their slopes (Birchfield and Tomasi, 1998) capture fine detail. Only
the finest filters are used: coarser ones blur across depth edges.
"""

from typing import Any, NamedTuple

import cv2
import numpy as np
from numba import njit, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from recon.stereo.filters import respond
from recon.stereo.kernels.shorts import NUM_SHORTS, ShortArray
from recon.stereo.kernels.simd import (
    FAST,
    NUM_LANES,
    Floats,
    Lanes,
    filled,
    kernel,
    larger,
    load,
    repeat,
    smaller,
    spread,
    store,
)

Grey = NDArray[np.uint8]
Bits = NDArray[np.uint64]

UNIT = 8
"""Costs are in eighths of a grey level."""

_WIDTHS_PX = (1.5,)
_PHASE = np.float32(20.0)
"""Cost of no similarity; opposite phases cost twice as much."""
_CENSUS = np.float32(0.75)
"""Cost of each of the 62 neighbours that is darker in one image only."""
_LEVEL = np.float32(0.6)
_SLOPE = np.float32(1.0)
_STEEPEST = 31.0
"""Slopes are truncated at this many levels: high-contrast edges would dominate otherwise."""
_UNSEEN = np.int16(30 * UNIT)
"""Cost of a right pixel outside the image: between those of wrong and correct matches."""
_BEYOND = np.int16(3000)
"""Cost of a disparity outside the search."""
_CENSUS_ROWS, _CENSUS_COLUMNS = 3, 4
_TINY = np.float32(1e-12)
_BOX = np.float32(1 / 9)


class Search(NamedTuple):
    """The disparities first, first + 1, ..., `size` in total."""

    first: int
    size: int

    @property
    def depth(self) -> int:
        """The size, padded to whole vectors."""
        return filled(self.size, NUM_SHORTS)


class _Side(NamedTuple):
    """One image in the layout of the loops; rows of the right one are reversed, with margins."""

    planes: Floats
    """(H, C, 3, W) real and imaginary response and inverse energy of each channel."""
    census: Bits
    """(H, W) one bit for each neighbour, 1 = darker than the pixel."""
    levels: Floats
    """(H, 3, W) brightness, and its minimum and maximum within half a pixel."""
    slopes: Floats
    """(H, 3, W) the same for the slope along the row."""


def cost_volume(left: Grey, right: Grey, search: Search) -> ShortArray:
    """Cost of every disparity at every left pixel.

    Parameters
    ----------
    left, right : (H, W) uint8
    search : Search

    Returns
    -------
    cost : (H, W, D) int16
        In units of 1 / `UNIT`; D padded to whole vectors.
    """
    depth = search.depth
    margin = filled(max(abs(search.first), abs(search.first + depth))) + NUM_LANES
    sides = _side(left), _backwards(_side(right), margin)
    cost = np.empty((*left.shape, depth), np.int16)
    _fill(*sides, search.first, search.size, cost)
    return cost


def _side(grey: Grey) -> _Side:
    height, width = grey.shape
    planes = respond(grey, _WIDTHS_PX).planes
    planes = planes.reshape(height, -1, 2, planes.shape[-1])[..., :width]
    energy = np.maximum(planes[:, :, 0] ** 2 + planes[:, :, 1] ** 2, _TINY)
    levels = grey.astype(np.float32)
    slopes = cv2.Sobel(levels, cv2.CV_32F, 1, 0, borderType=cv2.BORDER_REPLICATE)
    return _Side(
        planes=np.concatenate([planes, 1 / energy[:, :, None]], axis=2),
        census=_census(np.pad(grey, ((_CENSUS_ROWS,) * 2, (_CENSUS_COLUMNS,) * 2), mode="edge")),
        levels=_ranges(levels),
        slopes=_ranges(np.clip(slopes, -_STEEPEST, _STEEPEST)),
    )


def _backwards(side: _Side, margin: int) -> _Side:
    """The reversed rows, so that increasing disparities are ahead in memory."""

    def turned(rows: NDArray[Any]) -> NDArray[Any]:
        beside = [(0, 0)] * (rows.ndim - 1) + [(margin, margin)]
        return np.pad(rows[..., ::-1], beside, mode="edge")

    return _Side(turned(side.planes), turned(side.census), turned(side.levels), turned(side.slopes))


def _ranges(values: Floats) -> Floats:
    """(H, 3, W) values, and their minimum and maximum within half a pixel."""
    wide = np.pad(values, ((0, 0), (1, 1)), mode="edge")
    halves = (wide[:, :-1] + wide[:, 1:]) / 2
    three = np.stack([values, halves[:, :-1], halves[:, 1:]])
    return np.stack([values, three.min(axis=0), three.max(axis=0)], axis=1)


@njit(cache=True, nogil=True)
def _census(wide: Grey) -> Bits:
    height, width = wide.shape[0] - 2 * _CENSUS_ROWS, wide.shape[1] - 2 * _CENSUS_COLUMNS
    found = np.zeros((height, width), np.uint64)
    for v in range(height):
        for place in range((2 * _CENSUS_ROWS + 1) * (2 * _CENSUS_COLUMNS + 1)):
            row, column = divmod(place, 2 * _CENSUS_COLUMNS + 1)
            if (row, column) != (_CENSUS_ROWS, _CENSUS_COLUMNS):
                _compare(wide[v + row, column:], wide[v + _CENSUS_ROWS, _CENSUS_COLUMNS:], found[v])
    return found


@kernel
def _compare(other: Grey, middle: Grey, bits: Bits) -> None:
    for u in range(bits.size):
        bits[u] = (bits[u] << np.uint64(1)) | np.uint64(other[u] < middle[u])


@njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)
def _fill(left: _Side, right: _Side, first: int, count: int, cost: ShortArray) -> None:
    height, width, depth = cost.shape
    ring = np.empty((3, width, depth), np.float32)
    sums = np.empty((width + 2, depth), np.float32)
    line = np.empty(depth, np.float32)
    margin = (right.census.shape[1] - width) // 2
    _compare_levels(left, right, 0, margin + first, ring[0])
    for v in range(height):
        below = min(v + 1, height - 1)
        _compare_levels(left, right, below, margin + first, ring[below % 3])
        _add_rows(ring[max(v - 1, 0) % 3], ring[v % 3], ring[below % 3], sums)
        for u in range(width):
            start = margin + width - 1 - u + first
            _compare_phases(left.planes[v], u, right.planes[v], start, line)
            _add_up(line, left.census[v, u], right.census[v, start:], sums[u : u + 3], cost[v, u])
            _mark_ends(cost[v, u], u - first, width, count)


@kernel
def _compare_levels(left: _Side, right: _Side, v: int, start: int, out: Floats) -> None:
    """Write the differences (W, D) of levels and slopes of a row."""
    width, depth = out.shape
    for u in range(width):
        for d in range(0, depth, NUM_LANES):
            at = start + width - 1 - u + d
            levels = _apart(left.levels[v], u, right.levels[v], at)
            slopes = _apart(left.slopes[v], u, right.slopes[v], at)
            store(out[u], d, _LEVEL * levels + _SLOPE * slopes)


@kernel
def _apart(left: Floats, u: int, right: Floats, at: int) -> Lanes:
    """The distance between values, tolerant to sampling offsets of half a pixel."""
    value, low, high = repeat(left[0], u), repeat(left[1], u), repeat(left[2], u)
    other = load(right[0], at)
    one = larger(value - load(right[2], at), load(right[1], at) - value)
    two = larger(low - other, other - high)
    return larger(smaller(one, two), spread(np.float32(0)))


@kernel
def _add_rows(above: Floats, middle: Floats, below: Floats, sums: Floats) -> None:
    """Sum three rows (W, D) into rows 1 to W, replicating the first and last ones."""
    width, depth = above.shape
    for u in range(width):
        for d in range(depth):
            sums[u + 1, d] = above[u, d] + middle[u, d] + below[u, d]
    for d in range(depth):
        sums[0, d] = sums[1, d]
        sums[width + 1, d] = sums[width, d]


@kernel
def _compare_phases(left: Floats, u: int, right: Floats, start: int, line: Floats) -> None:
    """Write the cost of phase dissimilarity (Eqs 16 to 18), all channels with equal weight."""
    channels = left.shape[0]
    weight = _PHASE / np.float32(channels)
    for d in range(0, line.size, NUM_LANES):
        cost = spread(_PHASE)
        for c in range(channels):
            here, there, at = left[c], right[c], start + d
            dot = repeat(here[0], u) * load(there[0], at) + repeat(here[1], u) * load(there[1], at)
            cost = cost - weight * (dot * smaller(repeat(here[2], u), load(there[2], at)))
        store(line, d, cost)


@intrinsic
def _number_of_ones(typing_context: Any, bits: Any) -> Any:
    """The number of bits that are 1."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.ctpop(arguments[0])

    return types.uint64(types.uint64), generate


@kernel
def _add_up(phases: Floats, here: int, there: Bits, sums: Floats, cost: ShortArray) -> None:
    before, middle, behind = sums[0], sums[1], sums[2]
    for d in range(cost.size):
        unlike = np.float32(np.int32(_number_of_ones(here ^ there[d])))
        total = phases[d] + _CENSUS * unlike + _BOX * (before[d] + middle[d] + behind[d])
        cost[d] = np.int16(total * np.float32(UNIT))


@kernel
def _mark_ends(cost: ShortArray, column: int, width: int, count: int) -> None:
    """Mark disparities outside; number d of the pixel is the right pixel ``column - d``."""
    for d in range(max(0, column + 1), count):
        cost[d] = _UNSEEN
    for d in range(min(count, column - width + 1)):
        cost[d] = _UNSEEN
    for d in range(count, cost.size):
        cost[d] = _BEYOND
