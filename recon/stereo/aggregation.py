"""The best supported shift of each point, its rivals, and its side of an edge."""

from dataclasses import dataclass, fields
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.lanes import (
    FAST, NUM_LANES, Floats, Integers, Lanes, kernel, larger, largest, load, repeat, room, spread, store,
    total,
)  # fmt: skip
from recon.stereo.scores import Picture, Ring, Search, fill_row, line_start, make_ring
from recon.stereo.support import DIRECTIONS, LIKENESS, SIDE_RADIUS, Members, disc, half_disc

_RIVAL_GAP = 3
"""From so many shifts away another maximum is a rival: repetition, or an edge along a row."""
_CLOSED = np.float32(-1e9)
"""Support of a shift to a pixel that is no candidate."""


class Points(NamedTuple):
    """Pixels in the order of their rows."""

    u: Integers
    v: Integers
    orientation: Floats
    """(N,) of the edge's normal, in [0, pi]; (0,) where nobody asks for sides."""
    starts: Integers
    """(H + 1,) the first pixel of each row."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Support:
    """What the neighbourhood says of the shift of each point."""

    shift: NDArray[np.int64]
    """(N,) column of the best supported partner, less the point's own."""
    score: NDArray[np.float32]
    """(N,) its support; -inf where nothing can be matched."""
    rival: NDArray[np.float32]
    """(N,) support of the best other shift, as a share of `score`."""
    side: NDArray[np.float32]
    """(N,) how much more the half disc ahead along the normal has the shift than the other."""
    row_shift: NDArray[np.int64]
    """(N,) row of the partner, less the point's own."""


_Result = tuple[Integers, Floats, Floats, Floats]
_Four = tuple[Lanes, Lanes, Lanes, Lanes]


class _Window(NamedTuple):
    """Members of the windows of one kind, as places in a ring; (T, K) by parities and direction."""

    line: Integers
    """Rows from the uppermost that a ring holds."""
    offset: Integers
    """From the scores of the window's middle, but for the line."""
    pixel: Integers
    """From the middle in the flat picture with its margin."""
    weight: Floats


class _Task(NamedTuple):
    """The points of one picture that are sought in the other."""

    base: Picture
    other: Picture
    points: Points
    search: Search
    disc: _Window
    ahead: _Window
    behind: _Window


class _Room(NamedTuple):
    """Room for what one point needs, and for what the points of a row share."""

    lines: Integers
    """Where the lines of a ring begin, the uppermost row of a window first."""
    disc: Integers
    """(2, K) where the scores of the disc's members begin, for even and odd columns."""
    side: Integers
    """(K',) the same of a half disc."""
    weights: Floats
    """Of the disc's members."""
    support: Floats
    """Of each shift, filled up to whole lanes."""
    closed: Floats
    """Of the other row: 0, or `_CLOSED` where there is no candidate."""
    claims: Floats
    """(H, ...) highest support that any point of a row has for each pixel of the other row; (0, 0)
    where nobody asks."""


def aggregate(base: Picture, other: Picture, points: Points, search: Search) -> Support:
    """Support of all shifts of `search` at some points of `base`."""
    size = len(points.u)
    support = Support(
        shift=np.zeros(size, np.int64),
        score=np.full(size, -np.inf, np.float32),
        rival=np.zeros(size, np.float32),
        side=np.zeros(size, np.float32),
        row_shift=np.full(size, search.row_shift, np.int64),
    )
    ring = make_ring(base, search)
    task = _Task(base, other, points, search, *_windows(*_layout(ring, base)))
    _aggregate(
        task, ring, _make_room(task, ring),
        (support.shift, support.score, support.rival, support.side),
    )  # fmt: skip
    return support


def _layout(ring: Ring, base: Picture) -> tuple[int, int, int, int]:
    """What the windows' places depend on."""
    half = ring.rows * ring.columns * ring.lanes
    return ring.every, ring.lanes, half, base.mask.shape[1] + 2 * SIDE_RADIUS


@lru_cache(maxsize=16)
def _windows(every: int, lanes: int, half: int, stride: int) -> tuple[_Window, _Window, _Window]:
    """The disc, and the half discs ahead and behind."""
    kinds = disc(every), half_disc(+1, every), half_disc(-1, every)
    ours, ahead, behind = (_window(members, lanes, half, stride) for members in kinds)
    return ours, ahead, behind


def _window(members: Members, lanes: int, half: int, stride: int) -> _Window:
    # Rows of the tables are by parity of the middle's row, then of its column.
    odd = np.arange(len(members.du)) * 4 // len(members.du) % 2
    column = (odd[:, None] + members.du) >> 1
    return _Window(
        line=members.dv + SIDE_RADIUS,
        offset=column * lanes + members.slack * half,
        pixel=members.dv * stride + members.du,
        weight=members.weight,
    )


def _make_room(task: _Task, ring: Ring) -> _Room:
    height, width = task.base.mask.shape
    num_disc, num_side = (len(window.line[0]) for window in (task.disc, task.ahead))
    reach = width + abs(task.search.first) + ring.lanes
    return _Room(
        lines=np.zeros(2 * SIDE_RADIUS + 1, np.int64),
        disc=np.zeros((2, num_disc), np.int64),
        side=np.zeros(num_side, np.int64),
        weights=room(num_disc),
        support=room(ring.lanes),
        closed=np.zeros(2 * ring.columns + ring.lanes, np.float32),
        claims=np.full((height, reach) if task.search.is_unique else (0, 0), _CLOSED),
    )


def aggregate_rows(
    base: Picture, other: Picture, points: Points, search: Search, permission: int
) -> Support:
    """The best of the rows up to `permission` above and below."""
    best = aggregate(base, other, points, search)
    for row_shift in [sign * k for k in range(1, permission + 1) for sign in (-1, 1)]:
        found = aggregate(base, other, points, search._replace(row_shift=row_shift))
        better = found.score > best.score
        names = [field.name for field in fields(Support)]
        best = Support(**{n: np.where(better, getattr(found, n), getattr(best, n)) for n in names})
    return best


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _aggregate(task: _Task, ring: Ring, room: _Room, result: _Result) -> None:
    points, search = task.points, task.search
    height, width = task.base.mask.shape
    begin = points.starts[:-1].copy()
    end = begin.copy()
    for first in range(0, width, ring.width):
        for v in range(SIDE_RADIUS):
            fill_row(ring, v, first, task.base, task.other, search)
        for v in range(height):
            fill_row(ring, v + SIDE_RADIUS, first, task.base, task.other, search)
            while end[v] < points.starts[v + 1] and points.u[end[v]] < first + ring.width:
                end[v] += 1
            if begin[v] < end[v] and 0 <= v + search.row_shift < height:
                _judge(task, ring, room, (v, first, begin[v], end[v]), result)
            begin[v] = end[v]
    if search.is_unique:
        _reject(points, search, room.claims, result)


@kernel
def _judge(
    task: _Task, ring: Ring, room: _Room, stretch: tuple[int, int, int, int], result: _Result
) -> None:
    """Find shift and side of the points of a row of a strip: from one number to another."""
    v, first, begin, end = stretch
    left = first - SIDE_RADIUS
    _open(task.other.mask[v + task.search.row_shift], left + task.search.first, room.closed)
    for k in range(room.lines.size):
        room.lines[k] = line_start(ring, v + k - SIDE_RADIUS)
    for odd in range(2):
        _locate(task.disc, 2 * (v & 1) + odd, room.lines, room.disc[odd])
    for i in range(begin, end):
        place = ((task.points.u[i] - left) >> 1) * ring.lanes
        _choose(task, ring, room, (i, v, left, place), result)
        if task.points.orientation.size and result[1][i] > 0:
            _take_side(task, ring, room, (i, v, place), result)


@kernel
def _open(mask: NDArray[np.bool_], start: int, closed: Floats) -> None:
    """Mark the candidates of another row, from a column on."""
    closed[:] = _CLOSED
    for k in range(max(0, -start), min(closed.size, mask.size - start)):
        closed[k] = np.float32(0.0) if mask[start + k] else _CLOSED


@kernel
def _locate(window: _Window, row: int, lines: Integers, starts: Integers) -> None:
    """Write where the scores of a window's members begin, from its middle's on in its line."""
    line, offset = window.line[row], window.offset[row]
    for k in range(starts.size):
        starts[k] = lines[np.uint64(line[k])] + offset[k]


@kernel
def _choose(
    task: _Task, ring: Ring, room: _Room, point: tuple[int, int, int, int], result: _Result
) -> None:
    """Find the best supported shift of a point."""
    i, v, left, place = point
    u, search, support = task.points.u[i], task.search, room.support
    shift, score, rival, _ = result
    stride = task.base.mask.shape[1] + 2 * SIDE_RADIUS
    middle = (v + SIDE_RADIUS) * stride + u + SIDE_RADIUS
    row = 2 * (v & 1) + (u & 1)
    share = _weigh(task.base.grey, middle, task.disc, row, room.weights)
    _sum(ring.scores, place, room.disc[u & 1], room.weights, support)
    highest = _close(support, share, room.closed[u - left :])
    if search.is_unique:
        _claim(support, room.claims[v, max(0, -search.first) + u + search.first :])
    if highest > 0:
        best = 0
        while support[np.uint64(best)] < highest:
            best += 1
        shift[i] = search.first + best
        score[i] = highest
        _forget(support, best - _RIVAL_GAP + 1, best + _RIVAL_GAP)
        rival[i] = max(_highest(support), np.float32(0.0)) / highest


@kernel
def _weigh(
    picture: NDArray[np.uint8], middle: int, window: _Window, row: int, weights: Floats
) -> float:
    """Write the weights of the disc's members, the more alike the more; return 1 / their sum."""
    here = np.int64(picture[middle])
    pixel, weight = window.pixel[row], window.weight[row]
    for k in range(weight.size):
        there = np.int64(picture[np.uint64(middle + pixel[k])])
        weights[k] = weight[k] * LIKENESS[np.uint64(abs(there - here))]
    together = spread(0.0)
    for k in range(0, weight.size, NUM_LANES):
        together += load(weights, k)
    return float(np.float32(1.0) / (total(together) + np.float32(1e-6)))


@kernel
def _sum(scores: Floats, place: int, starts: Integers, weights: Floats, sums: Floats) -> None:
    """Write the weighted sums of the members' scores, shift by shift, from `place` on."""
    i = 0
    while i + 4 * NUM_LANES <= sums.size:
        _sum_four(scores, place + i, starts, weights, sums[i:])
        i += 4 * NUM_LANES
    if i < sums.size:
        _sum_two(scores, place + i, starts, weights, sums[i:])


@kernel
def _sum_four(scores: Floats, place: int, starts: Integers, weights: Floats, sums: Floats) -> None:
    # Two sums side by side, as one would wait for itself.
    nothing = spread(0.0)
    even = odd = nothing, nothing, nothing, nothing
    for k in range(0, starts.size, 2):
        even = _add_four(even, repeat(weights, k), scores, place + starts[k])
        odd = _add_four(odd, repeat(weights, k + 1), scores, place + starts[k + 1])
    store(sums, 0, even[0] + odd[0])
    store(sums, NUM_LANES, even[1] + odd[1])
    store(sums, 2 * NUM_LANES, even[2] + odd[2])
    store(sums, 3 * NUM_LANES, even[3] + odd[3])


@kernel
def _add_four(sums: _Four, weight: Lanes, scores: Floats, k: int) -> _Four:
    return (
        sums[0] + weight * load(scores, k),
        sums[1] + weight * load(scores, k + NUM_LANES),
        sums[2] + weight * load(scores, k + 2 * NUM_LANES),
        sums[3] + weight * load(scores, k + 3 * NUM_LANES),
    )


@kernel
def _sum_two(scores: Floats, place: int, starts: Integers, weights: Floats, sums: Floats) -> None:
    a = b = c = d = spread(0.0)
    for k in range(0, starts.size, 2):
        weight, start = repeat(weights, k), place + starts[k]
        a += weight * load(scores, start)
        b += weight * load(scores, start + NUM_LANES)
        weight, start = repeat(weights, k + 1), place + starts[k + 1]
        c += weight * load(scores, start)
        d += weight * load(scores, start + NUM_LANES)
    store(sums, 0, a + c)
    store(sums, NUM_LANES, b + d)


@kernel
def _close(support: Floats, share: float, closed: Floats) -> float:
    """Turn sums into means, and shut the shifts without a candidate; return the highest."""
    highest = spread(_CLOSED)
    for k in range(0, support.size, NUM_LANES):
        mean = share * load(support, k) + load(closed, k)
        store(support, k, mean)
        highest = larger(highest, mean)
    return float(largest(highest))


@kernel
def _claim(support: Floats, claims: Floats) -> None:
    """Note the highest support of each pixel of the other row."""
    for k in range(0, support.size, NUM_LANES):
        store(claims, k, larger(load(support, k), load(claims, k)))


@kernel
def _highest(support: Floats) -> float:
    highest = load(support, 0)
    for k in range(NUM_LANES, support.size, NUM_LANES):
        highest = larger(highest, load(support, k))
    return float(largest(highest))


@kernel
def _forget(support: Floats, first: int, end: int) -> None:
    """Shut the shifts from one to another."""
    for k in range(max(0, first), min(support.size, end)):
        support[k] = _CLOSED


@kernel
def _reject(points: Points, search: Search, claims: Floats, result: _Result) -> None:
    """Forget points whose partner supports another point of the row more."""
    shift, score, _, _ = result
    margin = max(0, -search.first)
    for v in range(claims.shape[0]):
        for i in range(points.starts[v], points.starts[v + 1]):
            if score[i] < claims[v, margin + points.u[i] + shift[i]]:
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
    side[i] = _evidence(task, task.ahead, ring, room, (row, place, best))
    side[i] -= _evidence(task, task.behind, ring, room, (row, place, best))


@kernel
def _evidence(
    task: _Task, window: _Window, ring: Ring, room: _Room, point: tuple[int, int, int]
) -> float:
    """How much a half disc has the best shift, and is not explained better as background.

    Shifts grow as disparities fall: what is farther away comes after.
    """
    row, place, best = point
    _locate(window, row, room.lines, room.side)
    first = best // (2 * NUM_LANES) * (2 * NUM_LANES)
    support = room.support[first:]
    _sum(ring.scores, place + first, room.side, window.weight[row], support)
    own = support[best - first]
    support[: best + 2 - first] = 0.0
    evidence: float = own - np.float32(0.5) * _highest(support)
    return evidence
