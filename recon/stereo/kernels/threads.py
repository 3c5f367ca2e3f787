"""Threads of one pair: compiled loops over bands of rows, which let go of the interpreter."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import TypeVar

Result = TypeVar("Result")


def num_threads() -> int:
    """Threads that a pair may use: as `NUMBA_NUM_THREADS` says, else one per processor."""
    said = os.environ.get("NUMBA_NUM_THREADS", "")
    if said.isdecimal() and int(said) > 0:
        return int(said)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def bands(size: int, least: int) -> list[tuple[int, int]]:
    """First and end of the bands of at least so many rows that the threads share."""
    number = max(1, min(num_threads(), size // least))
    edges = [size * k // number for k in range(number + 1)]
    return list(pairwise(edges))


def run(tasks: Sequence[Callable[[], Result]]) -> list[Result]:
    """Results of the tasks, in their order; side by side where threads are allowed."""
    workers = min(num_threads(), len(tasks))
    if workers < 2:
        return [task() for task in tasks]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(lambda task: task(), tasks))
