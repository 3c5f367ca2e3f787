"""Threads: the number a process may use, and calls made in threads."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import ContextVar, copy_context
from functools import partial
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

_is_in_thread = ContextVar("is_in_thread", default=False)
"""True inside a call made `alone`, whose own calls then run one after another."""


def num_processors() -> int:
    """Processors this process may use: Slurm's allowance, otherwise those it is bound to."""
    bound = (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    )
    allowed = os.environ.get("SLURM_CPUS_PER_TASK", "")
    return min(bound, int(allowed)) if allowed.isdecimal() and int(allowed) else bound


def num_threads() -> int:
    """Number of compute threads: `NUMBA_NUM_THREADS` if set, otherwise one per processor.

    A call of `in_threads` has one thread, its own.
    """
    if _is_in_thread.get():
        return 1
    said = os.environ.get("NUMBA_NUM_THREADS", "")
    return int(said) if said.isdecimal() and int(said) else num_processors()


def alone(call: Callable[..., Result]) -> Callable[..., Result]:
    """The call in a copy of this context, where it has one thread: that which makes it."""
    context = copy_context()
    context.run(_is_in_thread.set, True)
    return partial(context.run, call)


def in_threads(
    call: Callable[[Item], Result], items: Iterable[Item], most: int | None = None
) -> Iterator[Result]:
    """The result for each item, in order; at most one item per thread is in progress.

    The call should release the GIL for most of its time.

    Parameters
    ----------
    call : callable
    items : iterable
    most : int, optional
        Maximum number of threads; with 1 thread, the calls may start threads themselves.
    """
    number = num_threads() if most is None else min(most, num_threads())
    if number == 1:
        yield from map(call, items)
        return
    waiting: deque[Future[Result]] = deque()
    pool = ThreadPoolExecutor(number)
    try:
        for item in items:
            waiting.append(pool.submit(alone(call), item))
            if len(waiting) > number:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)
