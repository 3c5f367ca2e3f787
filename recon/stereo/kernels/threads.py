"""Threads of one pair: compiled loops over bands of its columns or matches, without the GIL."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from recon.threads import alone, num_processors, num_threads

Result = TypeVar("Result")


def bands(size: int, least: int, cost: NDArray[np.floating] | None = None) -> list[tuple[int, int]]:
    """Start and end of the bands that the threads share, at most one per `least` items.

    Parameters
    ----------
    size : int
        Number of items: columns or matches.
    least : int
    cost : (size + 1,) increasing, optional
        Cost of all items before each one; by default all cost the same.
    """
    number = max(1, min(num_threads(), size // least))
    if cost is None:
        edges = [size * k // number for k in range(number + 1)]
    else:
        inner = np.searchsorted(cost, cost[-1] * np.arange(1, number) / number)
        edges = [0, *inner.tolist(), size]
    return list(pairwise(edges))


def run(tasks: Sequence[Callable[[], Result]]) -> list[Result]:
    """Results of the tasks, in order; run in parallel if threads are allowed.

    Each thread, the calling one among them, takes every n-th task.
    """
    number = max(1, min(num_threads(), len(tasks)))
    if number == 1:
        return [task() for task in tasks]

    def share(first: int) -> list[Result]:
        return [task() for task in tasks[first::number]]

    others = [_helpers().submit(alone(share), first) for first in range(1, number)]
    shares = [alone(share)(0), *(other.result() for other in others)]
    return [shares[k % number][k // number] for k in range(len(tasks))]


@cache
def _helpers() -> ThreadPoolExecutor:
    """The threads that help: kept, as starting them takes a tenth of the time of a small pair."""
    return ThreadPoolExecutor(num_processors())


if hasattr(os, "register_at_fork"):  # threads do not survive a fork
    os.register_at_fork(after_in_child=_helpers.cache_clear)
