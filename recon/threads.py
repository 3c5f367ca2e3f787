"""Threads: how many a process may use, and calls made in them."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def num_processors() -> int:
    """Processors this process may use: Slurm's allowance, else those it is bound to."""
    bound = (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    )
    allowed = os.environ.get("SLURM_CPUS_PER_TASK", "")
    return min(bound, int(allowed)) if allowed.isdecimal() and int(allowed) else bound


def num_threads() -> int:
    """Threads to compute with: as `NUMBA_NUM_THREADS` says, else one per processor."""
    said = os.environ.get("NUMBA_NUM_THREADS", "")
    return int(said) if said.isdecimal() and int(said) else num_processors()


def in_threads(call: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """The result for each item, in order; no more items are in work than there are threads.

    The call should let go of the interpreter for most of its time.
    """
    number = num_threads()
    if number == 1:
        yield from map(call, items)
        return
    with ThreadPoolExecutor(number) as pool:
        waiting: deque[Future[Result]] = deque()
        for item in items:
            waiting.append(pool.submit(copy_context().run, call, item))
            if len(waiting) > number:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
