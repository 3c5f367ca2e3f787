"""The best-supported shift of each point, its rivals, and its side of an edge."""

from dataclasses import dataclass, fields
from functools import partial, reduce
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.kernels.memory import aligned_zeros
from recon.stereo.kernels.shorts import NUM_SHORTS, ShortArray
from recon.stereo.kernels.simd import FAST, NUM_LANES, Floats, Integers, filled, kernel
from recon.stereo.kernels.threads import bands, run
from recon.stereo.matching.cost import Responses, fill_row
from recon.stereo.matching.ring import ONE, Ring, make_ring, steps
from recon.stereo.matching.search import Search
from recon.stereo.matching.voting import (
    CLOSED,
    OPEN,
    add_up,
    claim,
    close,
    find,
    forget,
    locate,
    peak,
    weigh,
)
from recon.stereo.matching.windows import DIRECTIONS, SIDE_RADIUS, Window, windows

_LEAST_BAND = 96
"""Minimum columns of a thread's band, as its strips are computed with a margin on both sides."""
_POINTS_PER_PIXEL = 0.08
"""Time for the scores of a pixel, relative to that for the support of a point."""
_RIVAL_GAP = 3
"""Minimum distance, in shifts, of a rival maximum: repetition, or an edge along a row."""


class Points(NamedTuple):
    """Pixels in the order of their rows."""

    u: Integers
    v: Integers
    orientation: Floats
    """(N,) of the edge normal, in [0, pi]; (0,) if sides are not needed."""
    starts: Integers
    """(H + 1,) the first pixel of each row."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Support:
    """Aggregated evidence of the neighbourhood for the shift of each point."""

    shift: NDArray[np.int64]
    """(N,) column of the best-supported partner minus the point's own."""
    score: NDArray[np.float32]
    """(N,) its support; -inf if there is no match."""
    rival: NDArray[np.float32]
    """(N,) support of the best other shift, relative to `score`."""
    side: NDArray[np.float32]
    """(N,) excess evidence for the shift in the half disc ahead along the normal."""
    row_shift: NDArray[np.int64]
    """(N,) row of the partner minus the point's own."""


_Result = tuple[Integers, Floats, Floats, Floats]


class _Task(NamedTuple):
    """The points of one image to be found in the other."""

    base: Responses
    other: Responses
    points: Points
    search: Search
    disc: Window
    ahead: Window
    behind: Window


class _Room(NamedTuple):
    """Buffers for one point, and for the points of a row."""

    disc: Integers
    """(2, K) starts of the scores of the disc's members, for even and odd columns."""
    side: Integers
    """(K',) the same for a half disc."""
    weights: tuple[Floats, ShortArray]
    """Weights of the disc's members, and their shares of the sum."""
    support: ShortArray
    """Support of each shift, padded to whole shorts, in the unit of the scores."""
    limits: ShortArray
    """Highest possible support per pixel of the other row."""
    claims: ShortArray
    """(H, ...) highest support of any point of a row for each pixel of the other row; (0, 0) if not
    needed."""


def aggregate(base: Responses, other: Responses, points: Points, search: Search) -> Support:
    """Support of all shifts of `search` at some points of `base`."""
    size = len(points.u)
    support = Support(
        shift=np.zeros(size, np.int64),
        score=np.full(size, -np.inf, np.float32),
        rival=np.zeros(size, np.float32),
        side=np.zeros(size, np.float32),
        row_shift=np.full(size, search.row_shift, np.int64),
    )
    # Each thread has its own band of columns, ring and claims; the results do not depend on them.
    parts = _column_bands(points, base.mask.shape)
    rings = [make_ring(base.planes.shape[1], search, end - first) for first, end in parts]
    stride = base.mask.shape[1] + 2 * SIDE_RADIUS
    kinds = [windows(search.every, steps(ring), stride) for ring in rings]
    tasks = [_Task(base, other, points, search, *three) for three in kinds]
    rooms = [_make_room(*pair) for pair in zip(tasks, rings, strict=True)]
    result = support.shift, support.score, support.rival, support.side
    run([
        partial(_aggregate, *part, result) for part in zip(tasks, rings, rooms, parts, strict=True)
    ])  # fmt: skip
    if search.is_unique:
        claims = reduce(np.maximum, [room.claims for room in rooms])
        _reject(points, search.first, claims, support.shift, support.score)
    return support


def _column_bands(points: Points, shape: tuple[int, int]) -> list[tuple[int, int]]:
    """First and end column of bands of about equal cost, in whole lanes."""
    height, width = shape
    of_columns = np.bincount(points.u, minlength=filled(width)) + _POINTS_PER_PIXEL * height
    of_lanes = of_columns.reshape(-1, NUM_LANES).sum(axis=1)
    cost = np.concatenate([[0.0], np.cumsum(of_lanes)])
    edges = bands(len(of_lanes), _LEAST_BAND // NUM_LANES, cost)
    return [(NUM_LANES * first, NUM_LANES * end) for first, end in edges]


def _make_room(task: _Task, ring: Ring) -> _Room:
    height, width = task.base.mask.shape
    reach = width + abs(task.search.first) + ring.lanes
    num_disc, num_side = (len(window.row[0]) for window in (task.disc, task.ahead))
    return _Room(
        disc=np.zeros((2, num_disc), np.int64),
        side=np.zeros(num_side, np.int64),
        weights=(aligned_zeros(num_disc), np.zeros(num_disc, np.int16)),
        support=aligned_zeros(ring.lanes // 2).view(np.int16),
        limits=np.full(2 * ring.columns + ring.lanes, CLOSED),
        claims=np.full((height, reach) if task.search.is_unique else (0, 0), CLOSED),
    )


def aggregate_rows(
    base: Responses, other: Responses, points: Points, search: Search, permission: int
) -> Support:
    """The best of the rows up to `permission` above and below."""
    best = aggregate(base, other, points, search)
    for row_shift in [sign * k for k in range(1, permission + 1) for sign in (-1, 1)]:
        found = aggregate(base, other, points, search._replace(row_shift=row_shift))
        better = found.score > best.score
        names = [field.name for field in fields(Support)]
        best = Support(**{n: np.where(better, getattr(found, n), getattr(best, n)) for n in names})
    return best


@njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)
def _aggregate(
    task: _Task, ring: Ring, room: _Room, columns: tuple[int, int], result: _Result
) -> None:
    """Find support for the points of a band of columns, from the first to the end."""
    points, search = task.points, task.search
    height = task.base.mask.shape[0]
    begin = points.starts[:-1].copy()
    _advance(points, columns[0], begin)
    for first in range(columns[0], columns[1], ring.width):
        end = begin.copy()
        _advance(points, min(first + ring.width, columns[1]), end)
        # Above the image, too: the ring still contains the last rows of the previous strip.
        for v in range(-SIDE_RADIUS, SIDE_RADIUS):
            fill_row(ring, v, first, task.base, task.other, search)
        for v in range(height):
            fill_row(ring, v + SIDE_RADIUS, first, task.base, task.other, search)
            if begin[v] < end[v] and 0 <= v + search.row_shift < height:
                _judge(task, ring, room, (v, first, begin[v], end[v]), result)
        begin = end


@kernel
def _advance(points: Points, column: int, places: Integers) -> None:
    """Move from a point of each row to the first one that is not left of a column."""
    for v in range(places.size):
        while places[v] < points.starts[v + 1] and points.u[places[v]] < column:
            places[v] += 1


@kernel
def _judge(
    task: _Task, ring: Ring, room: _Room, stretch: tuple[int, int, int, int], result: _Result
) -> None:
    """Find shift and side of the points `begin` to `end` of a row of a strip."""
    v, first, begin, end = stretch
    left = first - SIDE_RADIUS
    _open(task.other.mask[v + task.search.row_shift], left + task.search.first, room.limits)
    for odd in range(2):
        locate(task.disc, 2 * (v & 1) + odd, ring, v, room.disc[odd])
    for i in range(begin, end):
        place = ((task.points.u[i] - left) >> 1) * ring.lanes
        _choose(task, ring, room, (i, v, left, place), result)
        if task.points.orientation.size and result[1][i] > 0:
            _take_side(task, ring, room, (i, v, place), result)


@kernel
def _open(mask: NDArray[np.bool_], start: int, limits: ShortArray) -> None:
    """Mark the candidates of another row, starting at a column."""
    limits[:] = CLOSED
    first = max(0, -start)
    inside, candidates = limits[first:], mask[start + first :]
    for k in range(min(inside.size, candidates.size)):
        inside[k] = OPEN if candidates[k] else CLOSED


@kernel
def _choose(
    task: _Task, ring: Ring, room: _Room, point: tuple[int, int, int, int], result: _Result
) -> None:
    """Find the best-supported shift of a point."""
    i, v, left, place = point
    u, search, support = task.points.u[i], task.search, room.support
    shift, score, rival, _ = result
    stride = task.base.mask.shape[1] + 2 * SIDE_RADIUS
    middle = (v + SIDE_RADIUS) * stride + u + SIDE_RADIUS
    row = 2 * (v & 1) + (u & 1)
    weigh(task.base.grey, middle, task.disc, row, room.weights)
    add_up(ring.scores, place, room.disc[u & 1], room.weights[1], support)
    highest = close(support, room.limits[u - left :])
    if search.is_unique:
        claim(support, room.claims[v, max(0, -search.first) + u + search.first :])
    if highest > 0:
        best = find(support, highest)
        shift[i] = search.first + best
        score[i] = np.float32(highest) / ONE
        forget(support, best - _RIVAL_GAP + 1, best + _RIVAL_GAP)
        rival[i] = np.float32(max(peak(support), 0)) / np.float32(highest)


@njit(cache=True, nogil=True)
def _reject(points: Points, first: int, claims: ShortArray, shift: Integers, score: Floats) -> None:
    """Reject points whose partner supports another point of the row more."""
    margin = max(0, -first)
    for i in range(shift.size):
        claimed = claims[points.v[i], margin + points.u[i] + shift[i]]
        if score[i] < np.float32(claimed) / ONE:
            score[i] = -np.inf


@kernel
def _take_side(
    task: _Task, ring: Ring, room: _Room, point: tuple[int, int, int], result: _Result
) -> None:
    """Compare the evidence of both half discs of a matched point."""
    i, v, place = point
    u, orientation = task.points.u[i], task.points.orientation[i]
    best = result[0][i] - task.search.first
    direction = min(int(orientation * DIRECTIONS / np.pi), DIRECTIONS - 1)
    row = (2 * (v & 1) + (u & 1)) * DIRECTIONS + direction
    side = result[3]
    side[i] = _evidence(task.ahead, ring, room, (row, v, place, best))
    side[i] -= _evidence(task.behind, ring, room, (row, v, place, best))


@kernel
def _evidence(window: Window, ring: Ring, room: _Room, where: tuple[int, int, int, int]) -> float:
    """Evidence that a half disc has the best shift, and is not better explained as background.

    Shifts increase as disparities decrease: the background comes after.
    """
    row, v, place, best = where
    locate(window, row, ring, v, room.side)
    first = best // NUM_SHORTS * NUM_SHORTS
    support = room.support[first:]
    add_up(ring.scores, place + first, room.side, window.share[row], support)
    own = np.float32(support[best - first])
    support[: best + 2 - first] = 0
    return float((own - np.float32(0.5) * np.float32(peak(support))) / ONE)
