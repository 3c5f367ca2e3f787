"""The best supported shift of each point, its rivals, and its side of an edge."""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.scores import Picture, Ring, Search, fill_row, locate, make_ring
from recon.stereo.lanes import FAST, Floats, Integers, kernel, weighted_sum
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


class _Task(NamedTuple):
    """The points of one picture that are sought in the other."""

    base: Picture
    other: Picture
    points: Points
    search: Search
    disc: Members
    ahead: Members
    behind: Members


class _Room(NamedTuple):
    """Room for where the members of a row's windows lie, and for the sums of one window."""

    disc: Integers
    ahead: Integers
    behind: Integers
    offsets: Integers
    """(4, K) of the disc's members in the flat picture with its margin."""
    weights: Floats
    total: Floats
    closed: Floats
    """Of the other row: 0, or `_CLOSED` where there is no candidate; with room on both sides."""
    claims: Floats
    """Highest support that any point of the row has for each pixel of the other row."""


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
    every = search.every
    windows = disc(every), half_disc(+1, every), half_disc(-1, every)
    task = _Task(base, other, points, search, *windows)
    _aggregate(task, (support.shift, support.score, support.rival, support.side))
    return support


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
def _aggregate(task: _Task, result: _Result) -> None:
    base, other, points, search = task.base, task.other, task.points, task.search
    height, width = base.mask.shape
    ring = make_ring(width, search.num_shifts, search.every)
    room = _make_room(task, ring)
    for v in range(SIDE_RADIUS):
        fill_row(ring, v, base, other, search)
    for v in range(height):
        fill_row(ring, v + SIDE_RADIUS, base, other, search)
        v_other = v + search.row_shift
        if points.starts[v] == points.starts[v + 1] or not 0 <= v_other < height:
            continue
        _open(other.mask[v_other], room, max(0, -search.first))
        locate(ring, v, task.disc, room.disc)
        _choose(ring, task, room, v, result)
        if search.is_unique:
            _reject(points, room, max(0, -search.first), v, result)
        if points.orientation.size:
            locate(ring, v, task.ahead, room.ahead)
            locate(ring, v, task.behind, room.behind)
            _take_sides(ring, task, room, v, result)


@njit(cache=True)
def _make_room(task: _Task, ring: Ring) -> _Room:
    width = task.base.mask.shape[1]
    members = task.disc.weight.shape[1]
    reach = abs(task.search.first) + width + task.search.num_shifts
    return _Room(
        np.zeros((2, 1, members), np.int64),
        np.zeros((2, DIRECTIONS, task.ahead.weight.shape[1]), np.int64),
        np.zeros((2, DIRECTIONS, task.behind.weight.shape[1]), np.int64),
        task.disc.dv * task.base.grey.shape[1] + task.disc.du,
        np.zeros(members, np.float32),
        np.zeros(task.search.num_shifts, np.float32),
        np.full(reach, _CLOSED, np.float32),
        np.full(reach, _CLOSED, np.float32),
    )


@kernel
def _open(mask: NDArray[np.bool_], room: _Room, margin: int) -> None:
    """Make ready for the candidates of another row, that nobody has claimed yet."""
    room.claims[:] = _CLOSED
    for u in range(mask.size):
        room.closed[margin + u] = np.float32(0.0) if mask[u] else _CLOSED


@kernel
def _choose(ring: Ring, task: _Task, room: _Room, v: int, result: _Result) -> None:
    """Find the best supported shift of each point of a row."""
    points, search, grey, total = task.points, task.search, task.base.grey, room.total
    shift, score, rival, _ = result
    picture = grey.reshape(-1)
    for i in range(points.starts[v], points.starts[v + 1]):
        u = points.u[i]
        parity = 2 * (v & 1) + (u & 1)
        middle = (v + SIDE_RADIUS) * grey.shape[1] + u + SIDE_RADIUS
        share = _weigh(
            picture, middle, room.offsets[parity], task.disc.weight[parity], room.weights
        )
        near = ring.scores[(u >> 1) * ring.lanes :]
        weighted_sum(near, room.disc[u & 1, 0], room.weights, total)
        start = max(0, -search.first) + u + search.first
        _claim(total, share, room.closed[start:], room.claims[start:])
        best, highest = _highest(total)
        if highest > 0:
            shift[i] = search.first + best
            score[i] = highest
            rival[i] = _rival(total, best) / highest


@kernel
def _weigh(
    picture: NDArray[np.uint8], middle: int, offsets: Integers, weight: Floats, weights: Floats
) -> float:
    """Write the weights of the disc's members, the more alike the more; return 1 / their sum."""
    here = np.int64(picture[middle])
    for k in range(weight.size):
        there = np.int64(picture[np.uint64(middle + offsets[k])])
        weights[k] = weight[k] * LIKENESS[np.uint64(abs(there - here))]
    total = np.float32(1e-6)
    for k in range(weight.size):
        total += weights[k]
    return float(np.float32(1.0) / total)


@kernel
def _claim(total: Floats, share: float, closed: Floats, claims: Floats) -> None:
    """Turn sums into means, shut those without a candidate, and note the highest of each."""
    for k in range(total.size):
        total[k] = total[k] * share + closed[k]
        claims[k] = max(claims[k], total[k])


@kernel
def _reject(points: Points, room: _Room, margin: int, v: int, result: _Result) -> None:
    """Forget points whose partner supports another point of the row more."""
    shift, score, _, _ = result
    for i in range(points.starts[v], points.starts[v + 1]):
        if score[i] < room.claims[margin + points.u[i] + shift[i]]:
            score[i] = -np.inf


@kernel
def _take_sides(ring: Ring, task: _Task, room: _Room, v: int, result: _Result) -> None:
    """Compare the evidence of both half discs of each matched point of a row."""
    points = task.points
    shift, score, _, side = result
    for i in range(points.starts[v], points.starts[v + 1]):
        if score[i] < 0:
            continue
        u, best = points.u[i], shift[i] - task.search.first
        direction = min(int(points.orientation[i] * DIRECTIONS / np.pi), DIRECTIONS - 1)
        row = (2 * (v & 1) + (u & 1)) * DIRECTIONS + direction
        # The shift itself and those of the background come from here on.
        near = ring.scores[(u >> 1) * ring.lanes + best :]
        average = room.total[best:]
        weighted_sum(near, room.ahead[u & 1, direction], task.ahead.weight[row], average)
        side[i] = _evidence(average)
        weighted_sum(near, room.behind[u & 1, direction], task.behind.weight[row], average)
        side[i] -= _evidence(average)


@kernel
def _highest(total: Floats) -> tuple[int, float]:
    highest = total[0]
    for k in range(total.size):
        highest = max(highest, total[k])
    best = 0
    while total[best] < highest:
        best += 1
    return best, highest


@kernel
def _rival(total: Floats, best: int) -> float:
    """The highest support that is not next to the best."""
    highest = np.float32(0.0)
    before = total[: max(0, best - _RIVAL_GAP + 1)]
    for k in range(before.size):
        highest = max(highest, before[k])
    after = total[best + _RIVAL_GAP :]
    for k in range(after.size):
        highest = max(highest, after[k])
    return float(highest)


@kernel
def _evidence(average: Floats) -> float:
    """How much a half disc has the first shift itself, and is not explained better as background.

    Shifts grow as disparities fall: what is farther away comes after.
    """
    background = np.float32(0.0)
    after = average[2:]
    for k in range(after.size):
        background = max(background, after[k])
    evidence: float = average[0] - np.float32(0.5) * background
    return evidence
