"""Threads of one pair: compiled loops over bands of rows, which release the GIL."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TypeVar

from recon.threads import in_threads, num_threads

Result = TypeVar("Result")


def bands(size: int, least: int) -> list[tuple[int, int]]:
    """Start and end of the bands of at least `least` rows that the threads share."""
    number = max(1, min(num_threads(), size // least))
    edges = [size * k // number for k in range(number + 1)]
    return list(pairwise(edges))


def run(tasks: Sequence[Callable[[], Result]]) -> list[Result]:
    """Results of the tasks, in order; run in parallel if threads are allowed."""
    return list(in_threads(lambda task: task(), tasks))
