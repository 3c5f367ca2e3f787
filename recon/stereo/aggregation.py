"""The best supported disparity of each point, its rivals, and its side of an edge."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.scores import (
    Ring,
    Search,
    Side,
    fill_row,
    locate,
    make_ring,
)  # fmt: skip
from recon.stereo.support import (
    AHEAD,
    BEHIND,
    DIRECTIONS,
    DISC,
    FAST,
    LIKENESS,
    SIDE_RADIUS,
    Floats,
    Integers,
    add_votes,
)  # fmt: skip

_RIVAL_GAP = 3
"""From so many disparities away another maximum is a rival: repetition, or an edge along a row."""
_SIDE_PRIOR = np.float32(0.05)
"""Added to the weight of a half disc, so that few pixels do not decide."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Support:
    """What the neighbourhood says of the disparity of each point."""

    disparity: NDArray[np.int64]
    """(N,) the best supported disparity."""
    score: NDArray[np.float32]
    """(N,) its support; -inf where nothing can be matched."""
    rival: NDArray[np.float32]
    """(N,) support of the best other disparity, as a share of `score`."""
    side: NDArray[np.float32]
    """(N,) how much more the half disc ahead along the normal has the disparity than the other."""


_Result = tuple[Integers, Floats, Floats, Floats]


class Points(NamedTuple):
    """Pixels in the order of their rows."""

    u: Integers
    v: Integers
    orientation: Floats
    starts: Integers
    """(H + 1,) the first pixel of each row."""


class _Task(NamedTuple):
    """The points of one picture that are sought in the other."""

    base: Side
    other: Side
    points: Points
    search: Search


class _Room(NamedTuple):
    """Room for where the members of a row's windows lie, and for the sums of one window."""

    disc: Integers
    ahead: Integers
    behind: Integers
    weights: Floats
    total: Floats
    side: Floats


def aggregate(base: Side, other: Side, points: Points, search: Search) -> Support:
    """Support of all disparities of `search` at some points of `base`."""
    size = len(points.u)
    support = Support(
        disparity=np.zeros(size, np.int64),
        score=np.full(size, -np.inf, np.float32),
        rival=np.zeros(size, np.float32),
        side=np.zeros(size, np.float32),
    )
    task = _Task(base, other, points, search)
    _aggregate(task, (support.disparity, support.score, support.rival, support.side))
    return support


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _aggregate(task: _Task, result: _Result) -> None:
    base, other, points, search = task
    height, width = base.mask.shape
    ring = make_ring(width, search.num_disparities)
    room = _Room(
        np.empty((2, 1, DISC.weight.shape[1]), np.int64),
        np.empty((2, DIRECTIONS, AHEAD.weight.shape[1]), np.int64),
        np.empty((2, DIRECTIONS, BEHIND.weight.shape[1]), np.int64),
        np.empty(DISC.weight.shape[1], np.float32),
        np.empty(ring.lanes, np.float32),
        np.empty(ring.lanes, np.float32),
    )
    for v in range(SIDE_RADIUS):
        fill_row(ring, v, base, other, search)
    for v in range(height):
        fill_row(ring, v + SIDE_RADIUS, base, other, search)
        locate(ring, v, DISC, room.disc)
        locate(ring, v, AHEAD, room.ahead)
        locate(ring, v, BEHIND, room.behind)
        for i in range(points.starts[v], points.starts[v + 1]):
            _decide(ring, task, room, i, result)


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _decide(ring: Ring, task: _Task, room: _Room, i: int, result: _Result) -> None:
    base, other, points, search = task
    u, v = points.u[i], points.v[i]
    disparity, score, rival, side = result
    odd, parity = u & 1, (u + v) & 1
    near = ring.scores[(u >> 1) * ring.lanes :]
    _support(near, base.grey, u, v, room)
    best = _best(room.total, other.mask, u, v, search, -1)
    if best < 0:
        return
    disparity[i] = search.lowest + best
    score[i] = room.total[best]
    second = _best(room.total, other.mask, u, v, search, best)
    if second >= 0 and room.total[best] > 0:
        rival[i] = max(room.total[second], np.float32(0.0)) / room.total[best]
    k = int(np.rint(points.orientation[i] * DIRECTIONS / np.pi)) % DIRECTIONS
    row = parity * DIRECTIONS + k
    ahead = _evidence(near, room.ahead[odd, k], AHEAD.weight[row], room.side, search, best)
    behind = _evidence(near, room.behind[odd, k], BEHIND.weight[row], room.side, search, best)
    side[i] = ahead - behind


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _support(near: Floats, grey: NDArray[np.uint8], u: int, v: int, room: _Room) -> None:
    """Mean score of the members of the disc, the more alike the more worth."""
    parity = (u + v) & 1
    here = np.int64(grey[v + SIDE_RADIUS, u + SIDE_RADIUS])
    sum_weights = np.float32(1e-6)
    for k in range(room.weights.size):
        row = v + DISC.dv[parity, k] + SIDE_RADIUS
        there = np.int64(grey[row, u + DISC.du[parity, k] + SIDE_RADIUS])
        weight = DISC.weight[parity, k] * LIKENESS[abs(there - here)]
        room.weights[k] = weight
        sum_weights += weight
    add_votes(near, room.disc[u & 1, 0], room.weights, room.total)
    room.total[:] /= sum_weights


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _best(
    total: Floats, mask: NDArray[np.bool_], u: int, v: int, search: Search, excluded: int
) -> int:
    """The best supported candidate that is no neighbour of an excluded one; -1 = none."""
    best = -1
    v_other = v + search.row_shift
    if not 0 <= v_other < mask.shape[0]:
        return best
    first = max(0, u - search.lowest - mask.shape[1] + 1)
    for d in range(first, min(search.num_disparities, u - search.lowest + 1)):
        if excluded >= 0 and abs(d - excluded) < _RIVAL_GAP:
            continue
        if mask[v_other, u - search.lowest - d] and (best < 0 or total[d] > total[best]):
            best = d
    return best


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _evidence(
    near: Floats, starts: Integers, weights: Floats, total: Floats, search: Search, d: int
) -> float:
    """How much a half disc has disparity d itself, and is not explained better as background."""
    add_votes(near, starts, weights, total)
    background = np.float32(0.0)
    for k in range(d - 1):
        background = max(background, total[k])
    sum_weights = total[search.num_disparities]
    evidence: float = (total[d] - np.float32(0.5) * background) / (sum_weights + _SIDE_PRIOR)
    return evidence
