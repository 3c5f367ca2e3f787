"""Threads of one pair: compiled loops over bands of its columns or matches, without the GIL."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from recon.threads import in_threads, num_threads

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
    """Results of the tasks, in order; run in parallel if threads are allowed."""
    return list(in_threads(lambda task: task(), tasks))
