"""Matching of pairs ahead of the loop: read in a thread, matched side by side, yielded in order."""

import contextvars
import itertools
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

from recon.mapping.pair import PairResult, match_points
from recon.processes import begin_worker
from recon.records import PairSource, StereoPair
from recon.runs.replay import SavedResults
from recon.runs.work import Work
from recon.settings import Settings
from recon.threads import in_threads

Item = TypeVar("Item")
Matched = tuple[StereoPair, PairResult]
DEPTH = 2
"""Number of pairs read ahead, and of pairs in progress per worker."""
PIXELS_AT_ONCE = 4 << 20
"""Pixels of the left images that are matched at once, with some 300 bytes each; the threads share a
larger image."""


def read_ahead(source: Iterable[Item]) -> Iterator[Item]:
    """The items of a source, in order, read in a thread while earlier ones are processed."""
    items, context = iter(source), contextvars.copy_context()

    def read() -> list[Item]:
        """The next item in a list, which is empty at the end."""
        return context.run(lambda: list(itertools.islice(items, 1)))

    with ThreadPoolExecutor(1) as reader:
        waiting = deque(reader.submit(read) for _ in range(DEPTH))
        while item := waiting.popleft().result():
            waiting.append(reader.submit(read))
            yield item[0]


def match_ahead(source: PairSource, settings: Settings, work: Work) -> Iterator[Matched]:
    """Every pair with its matches and points, in order.

    Results are saved until the run is finished, and reused when an interrupted run is resumed. They
    are byte-identical for any number of threads and workers.
    """
    saved, pairs = SavedResults(folder=work.run.partial), read_ahead(source)
    if work.num_workers > 1:
        yield from _in_processes(pairs, settings, saved, work)
        return

    def match(numbered: tuple[int, StereoPair]) -> Matched:
        number, pair = numbered
        done = saved.load(number)
        return pair, saved.keep(number, match_points(pair, settings)) if done is None else done

    read = _timed(pairs, work, "reading")
    first = list(itertools.islice(read, 1))
    most = _num_at_once(first, len(source))
    matched = in_threads(match, enumerate(itertools.chain(first, read)), most)
    yield from _timed(matched, work, "stereo")


def _num_at_once(first: list[StereoPair], num_pairs: int) -> int:
    """Number of pairs that are matched side by side, at least 1."""
    num_pixels = sum(pair.rig.width * pair.rig.height for pair in first)
    return max(1, min(num_pairs, PIXELS_AT_ONCE // max(num_pixels, 1)))


def _timed(items: Iterator[Item], work: Work, stage: str) -> Iterator[Item]:
    """The items, whose production is counted for a stage."""
    while True:
        with work.stage(stage):
            found = list(itertools.islice(items, 1))
        if not found:
            return
        yield found[0]


def _in_processes(
    pairs: Iterator[StereoPair], settings: Settings, saved: SavedResults, work: Work
) -> Iterator[Matched]:
    working: deque[tuple[int, StereoPair, Future[PairResult] | PairResult]] = deque()
    with ProcessPoolExecutor(
        work.num_workers, mp_context=get_context("spawn"), initializer=begin_worker, initargs=(1,)
    ) as pool:
        for number, pair in enumerate(pairs):
            done = saved.load(number)
            future = done or pool.submit(match_points, pair, settings)
            working.append((number, pair, future))
            if len(working) == DEPTH * work.num_workers:
                yield _settled(*working.popleft(), saved, work)
        while working:
            yield _settled(*working.popleft(), saved, work)


def _settled(
    number: int,
    pair: StereoPair,
    future: Future[PairResult] | PairResult,
    saved: SavedResults,
    work: Work,
) -> Matched:
    """A pair with its result, once it is available."""
    if isinstance(future, PairResult):
        return pair, future
    with work.stage("stereo"):
        result = future.result()
    return pair, saved.keep(number, result)
