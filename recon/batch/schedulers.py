"""Schedulers of batch jobs: local processes or a Dask cluster."""

import logging
import queue
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing.context import BaseContext
from typing import Any, Protocol

from recon.batch.progress import Pipes, set_up_worker
from recon.batch.worker import Outcome, Progress, ignore_progress, report_progress_to
from recon.errors import InputError
from recon.files import Limits
from recon.libraries import THREAD_VARIABLES, limit_threads, load_extra
from recon.processes import SPAWN
from recon.threads import num_processors, num_threads

Call = Callable[[], Outcome]
"""Runs one job."""
_LOCAL = {
    # Not Dask's own environment, in which memory freed goes back to the system at once, and has to
    # be got again page by page.
    "distributed.nanny.pre-spawn-environ": dict.fromkeys(THREAD_VARIABLES, "1")
    | {"MALLOC_ARENA_MAX": "1"},
    # By default its threads interrupt a job hundreds of times per second to observe it.
    "distributed.worker.profile.enabled": False,
    "distributed.admin.system-monitor.gil.enabled": False,
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.admin.tick.interval": "500ms",
}
"""Configuration of a local Dask cluster."""
TOPIC = "recon-progress"
"""Topic of Dask events for the progress of jobs."""
MAX_TRIES = 3
"""Maximum number of tries of a job whose worker is killed, for instance for lack of memory."""


class Scheduler(Protocol):
    """Runs calls somewhere, in any order."""

    def outcomes(self, calls: Sequence[tuple[str, Call]]) -> Iterator[Outcome]:
        """The outcome of each named call, as it ends."""
        ...


class Processes:
    """Local processes.

    Each worker is a pool of one process, so that a dying worker affects only one job.

    Parameters
    ----------
    num_workers : int
        If there are fewer jobs, each gets the threads of several workers, as far as there are
        processors for them.
    progress : callable
        Called with the progress of each job.
    start : multiprocessing context
        The way to start workers.
    """

    def __init__(
        self, num_workers: int, progress: Progress = ignore_progress, start: BaseContext = SPAWN
    ) -> None:
        self._num_workers = num_workers
        self._progress = progress
        self._start = start
        self._lock = threading.Lock()

    def outcomes(self, calls: Sequence[tuple[str, Call]]) -> Iterator[Outcome]:
        """The outcome of each named call, as it ends."""
        self._pipes = Pipes(self._progress)
        self._idle: queue.SimpleQueue[ProcessPoolExecutor] = queue.SimpleQueue()
        self._pools: list[ProcessPoolExecutor] = []
        num_pools = min(self._num_workers, len(calls))
        allowed = min(self._num_workers, num_processors())
        self._num_threads = max(1, allowed // max(num_pools, 1))
        for _ in range(num_pools):
            self._idle.put(self._new_pool())
        threads = ThreadPoolExecutor(self._num_workers)
        is_cut = True
        try:
            with self._pipes.listening():
                futures = [threads.submit(self._do, name, call) for name, call in calls]
                for future in as_completed(futures):
                    yield future.result()
            is_cut = False
        finally:
            threads.shutdown(wait=False, cancel_futures=True)
            for pool in self._pools:
                # They end while the summary is written. Python would wait for them anyway where a
                # batch is interrupted, and may fail to wake those that are just ending.
                pool.shutdown(wait=is_cut, cancel_futures=True)

    def _new_pool(self) -> ProcessPoolExecutor:
        pool = ProcessPoolExecutor(
            1,
            mp_context=self._start,
            initializer=set_up_worker,
            initargs=(self._num_threads, self._pipes.new()),
        )
        with self._lock:
            self._pools.append(pool)
        return pool

    def _do(self, name: str, call: Call) -> Outcome:
        for _ in range(MAX_TRIES):
            pool = self._idle.get()
            try:
                outcome = pool.submit(call).result()
            except BrokenProcessPool:
                self._idle.put(self._new_pool())
            else:
                self._idle.put(pool)
                return outcome
        return lost(name)


class Dask:
    """A Dask cluster: an existing one, or a local one.

    Parameters
    ----------
    address : str
        "local", or the address of a scheduler, "tcp://HOST:PORT".
    num_workers : int
        Workers of a local cluster.
    progress : callable
        Called with the progress of each job.
    start : multiprocessing context
        The way to start workers of a local cluster.
    """

    def __init__(
        self,
        address: str,
        num_workers: int,
        progress: Progress = ignore_progress,
        start: BaseContext = SPAWN,
    ) -> None:
        self._progress = progress
        self._start = start
        self._distributed: Any = load_extra("distributed", "cluster")
        # It logs much more than one line per fault.
        for name in ("distributed", "distributed.client"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
        self._address = address
        self._num_workers = num_workers

    def outcomes(self, calls: Sequence[tuple[str, Call]]) -> Iterator[Outcome]:
        """The outcome of each named call, as it ends."""
        with self._client() as client:
            client.subscribe_topic(TOPIC, lambda event: self._progress(*event[1]))
            names = {}
            for name, call in calls:
                future = client.submit(run_on_dask, call, pure=False, key=f"recon-{name}")
                names[future] = name
            for future in self._distributed.as_completed(list(names)):
                yield self._outcome(names[future], future)

    def _outcome(self, name: str, future: Any) -> Outcome:
        """The outcome of a job; its own failures are outcomes, all other errors are Dask's."""
        if future.status == "finished":
            found: Outcome = future.result()
            return found
        if future.status != "error":
            fault = f"the connection to the scheduler at {self._address} was lost"
        elif isinstance(error := future.exception(), self._distributed.KilledWorker):
            return lost(name)
        else:
            fault = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return Outcome(name=name, state="failed", error=fault)

    def _client(self) -> Any:
        if self._address != "local":
            try:
                return self._distributed.Client(self._address, timeout="10s")
            except (OSError, ValueError) as error:
                raise InputError(f"no Dask scheduler answers at {self._address}") from error
        config = load_extra("dask.config", "cluster")
        way = {"distributed.worker.multiprocessing-method": self._start.get_start_method()}
        with config.set(_LOCAL | way):
            # A client without a cluster creates one and stops it when closed.
            return self._distributed.Client(
                n_workers=self._num_workers, threads_per_worker=1, dashboard_address=None
            )


def run_on_dask(call: Call) -> Outcome:
    """Run a job on a Dask worker, which publishes its progress."""
    worker = load_extra("distributed", "cluster").get_worker()
    limit_threads(num_threads())
    report_progress_to(lambda *progress: worker.log_event(TOPIC, progress))
    return call()


def lost(name: str) -> Outcome:
    """The outcome of a job whose workers died."""
    error = f"its worker died {MAX_TRIES} times; is there enough memory for it?"
    return Outcome(name=name, state="failed", error=error)


def make_scheduler(
    address: str | None,
    num_workers: int,
    progress: Progress = ignore_progress,
    start: BaseContext = SPAWN,
) -> Scheduler:
    """Local processes if no address is given, else a Dask cluster.

    Raises
    ------
    InputError
        If the address is not one.
    """
    if address is None:
        return Processes(num_workers, progress, start)
    if address != "local" and ":" not in address:
        raise InputError(f"scheduler is {address!r}, but local or tcp://HOST:PORT is needed")
    return Dask(address, num_workers, progress, start)


def bound(call: Callable[..., Outcome], *arguments: Any) -> Call:
    """A call bound to its arguments and the limits of this context, to be sent to a worker."""
    return partial(_limited, Limits.current(), call, *arguments)


def _limited(limits: Limits, call: Callable[..., Outcome], *arguments: Any) -> Outcome:
    with limits.applied():
        return call(*arguments)
