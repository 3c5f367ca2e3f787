"""Routes: the order in which to visit some positions, from the first on and ending anywhere."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.exploration.floor import ROUNDING, Array

Order = list[int]
Turn = tuple[int, int]
"""First and last index of a segment to reverse."""
Shift = tuple[int, int, int, bool]
"""First and last index of a segment to move, the index after which it goes, and whether it is
reversed."""

MAX_SHIFTED = 3
"""Longest segment that is moved: longer ones are rarely where they do not belong (Or, 1976)."""


def nearest_first(legs: Array) -> Order:
    """Order of a tour over N positions that always continues to the nearest, from the first."""
    tour = np.arange(len(legs))
    _continue(tour, 1, legs)
    return _listed(tour)


def _listed(tour: NDArray[np.intp]) -> Order:
    return [int(number) for number in tour]


@njit(cache=True)
def _continue(tour: NDArray[np.intp], first: int, legs: Array) -> None:
    """Order a tour from an index on, in place: always the nearest position left."""
    for index in range(first, len(tour)):
        nearest = index
        for other in range(index + 1, len(tour)):
            if legs[tour[index - 1], tour[other]] < legs[tour[index - 1], tour[nearest]]:
                nearest = other
        _bring(tour, nearest, index)


@njit(cache=True)
def _bring(tour: NDArray[np.intp], last: int, first: int) -> None:
    """Move one position of a tour forward, in place; the others keep their order."""
    place = tour[last]
    tour[first + 1 : last + 1] = tour[first:last].copy()
    tour[first] = place


def shortest(legs: Array) -> Order:
    """Order of a short tour over N positions: that of the given order and of many others.

    The others begin with one position each and continue to the nearest. All are improved until
    neither reversing nor moving a segment shortens them, which finds the shortest tour of the few
    positions of a round nearly always.

    Parameters
    ----------
    legs : (N, N)
        Lengths of the ways between the positions.
    """
    found = _tours(legs, ROUNDING * legs.max(initial=0.0))
    lengths = legs[found[:, :-1], found[:, 1:]].sum(axis=1)
    # Of tours equal up to rounding, the first is taken.
    return _listed(found[np.argmax(lengths <= (1.0 + ROUNDING) * np.min(lengths))])


@njit(cache=True)
def _tours(legs: Array, least: float) -> NDArray[np.intp]:
    """Tours (N, N), improved: of the given order, and by each position that may come second."""
    number = len(legs)
    tours = np.empty((number, number), np.intp)
    for second in range(number):
        tours[second] = np.arange(number)
        if second > 0:
            _bring(tours[second], second, 1)
            _continue(tours[second], 2, legs)
        _settle(tours[second], legs, least)
    return tours


def improved(order: Order, legs: Array) -> Order:
    """The tour with segments reversed while that shortens it (2-opt); its start is kept."""
    tour = np.array(order)
    least = ROUNDING * legs.max(initial=0.0)
    while (turn := _best_turn(tour, legs, least)) != (0, 0):
        _reverse(tour, *turn)
    return _listed(tour)


@njit(cache=True)
def _settle(tour: NDArray[np.intp], legs: Array, least: float) -> None:
    """Reverse and move segments of a tour, in place, while that shortens it."""
    while True:
        first, last = _best_turn(tour, legs, least)
        if last > 0:
            _reverse(tour, first, last)
            continue
        shift = _best_shift(tour, legs, least)
        if shift[1] == 0:
            return
        tour[:] = _shifted(tour, shift)


@njit(cache=True)
def _reverse(tour: NDArray[np.intp], first: int, last: int) -> None:
    tour[first : last + 1] = tour[first : last + 1][::-1].copy()


@njit(cache=True)
def _best_turn(tour: NDArray[np.intp], legs: Array, least: float) -> Turn:
    """The segment to reverse for the shortest tour; 0, 0 if none helps."""
    best, first, last = least, 0, 0
    for i in range(1, len(tour)):
        for j in range(i + 1, len(tour)):
            gain = legs[tour[i - 1], tour[i]] - legs[tour[i - 1], tour[j]]
            if j + 1 < len(tour):
                gain += legs[tour[j], tour[j + 1]] - legs[tour[i], tour[j + 1]]
            if gain > best:
                best, first, last = gain, i, j
    return first, last


@njit(cache=True)
def _best_shift(tour: NDArray[np.intp], legs: Array, least: float) -> Shift:
    """The segment to move for the shortest tour; zeros if none helps."""
    best, found = least, (0, 0, 0, False)
    for first in range(1, len(tour)):
        for last in range(first, min(first + MAX_SHIFTED, len(tour))):
            gain, after, is_reversed = _best_place(tour, legs, first, last)
            if gain > best:
                best, found = gain, (first, last, after, is_reversed)
    return found


@njit(cache=True)
def _best_place(
    tour: NDArray[np.intp], legs: Array, first: int, last: int
) -> tuple[float, int, bool]:
    """Length that moving a segment saves, the index after which it goes, and whether reversed."""
    begin, end, before = tour[first], tour[last], tour[first - 1]
    saved = legs[before, begin] + _onward(tour, legs, last, end) - _onward(tour, legs, last, before)
    most, place, is_reversed = -np.inf, 0, False
    for after in range(len(tour)):
        if after < first - 1 or after > last:
            here = tour[after]
            forth = legs[here, begin] + _onward(tour, legs, after, end)
            back = legs[here, end] + _onward(tour, legs, after, begin)
            gain = saved - min(forth, back) + _onward(tour, legs, after, here)
            if gain > most:
                most, place, is_reversed = gain, after, back < forth
    return most, place, is_reversed


@njit(cache=True)
def _onward(tour: NDArray[np.intp], legs: Array, index: int, place: int) -> float:
    """Length of the way from a position to what follows an index of the tour; 0 at its end."""
    if index + 1 == len(tour):
        return 0.0
    length: float = legs[place, tour[index + 1]]
    return length


@njit(cache=True)
def _shifted(tour: NDArray[np.intp], shift: Shift) -> NDArray[np.intp]:
    """The tour with a segment moved."""
    first, last, after, is_reversed = shift
    segment = tour[first : last + 1].copy()
    if is_reversed:
        segment = segment[::-1].copy()
    rest = np.concatenate((tour[:first], tour[last + 1 :]))
    split = after + 1 if after < first else after + 1 - len(segment)
    return np.concatenate((rest[:split], segment, rest[split:]))
