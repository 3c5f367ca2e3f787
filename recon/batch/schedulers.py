"""Schedulers: who does the jobs of a batch, processes of this machine or a Dask cluster."""

import queue
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing import get_context
from typing import Any, Protocol

from recon.batch.worker import Outcome
from recon.libraries import limit_threads, load_extra

Call = Callable[..., Outcome]
"""Does one job; takes the function that hears of its progress."""
MAX_TRIES = 3
"""So often a job is begun whose worker is lost, as by the kernel for want of memory."""


class Scheduler(Protocol):
    """Does calls somewhere, in any order."""

    def outcomes(self, calls: Sequence[tuple[str, Call]]) -> Iterator[Outcome]:
        """What comes of each named call, as it ends."""
        ...


class Processes:
    """Processes of this machine.

    Each of the workers is a pool of one, so that a worker that dies takes one job with it.

    Parameters
    ----------
    num_workers : int
    num_threads : int
        Of each worker.
    """

    def __init__(self, num_workers: int, num_threads: int = 1) -> None:
        self._num_workers = num_workers
        self._num_threads = num_threads
        self._idle: queue.SimpleQueue[ProcessPoolExecutor] = queue.SimpleQueue()
        self._pools: list[ProcessPoolExecutor] = []
        self._lock = threading.Lock()

    def outcomes(self, calls: Sequence[tuple[str, Call]]) -> Iterator[Outcome]:
        """What comes of each named call, as it ends."""
        for _ in range(min(self._num_workers, len(calls))):
            self._idle.put(self._new_pool())
        threads = ThreadPoolExecutor(self._num_workers)
        try:
            futures = [threads.submit(self._do, name, call) for name, call in calls]
            for future in as_completed(futures):
                yield future.result()
        finally:
            threads.shutdown(wait=False, cancel_futures=True)
            for pool in self._pools:
                pool.shutdown(wait=True, cancel_futures=True)

    def _new_pool(self) -> ProcessPoolExecutor:
        pool = ProcessPoolExecutor(
            1,
            mp_context=get_context("spawn"),
            initializer=limit_threads,
            initargs=(self._num_threads,),
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
    """A Dask cluster: one that runs already, or one of this machine.

    Parameters
    ----------
    address : str
        "local", or the address of a scheduler, "tcp://HOST:PORT".
    num_workers : int
        Of a local cluster.
    """

    def __init__(self, address: str, num_workers: int) -> None:
        self._distributed: Any = load_extra("distributed", "cluster")
        self._address = address
        self._num_workers = num_workers

    def outcomes(self, calls: Sequence[tuple[str, Call]]) -> Iterator[Outcome]:
        """What comes of each named call, as it ends."""
        with self._client() as client:
            names = {}
            for name, call in calls:
                future = client.submit(call, pure=False, key=f"recon-{name}")
                names[future] = name
            for future in self._distributed.as_completed(list(names)):
                # A worker that died, again and again; what the job itself raises is an outcome.
                if future.status != "finished":
                    yield lost(names[future])
                else:
                    yield future.result()

    def _client(self) -> Any:
        if self._address != "local":
            return self._distributed.Client(self._address, timeout="10s")
        cluster = self._distributed.LocalCluster(
            n_workers=self._num_workers, threads_per_worker=1, dashboard_address=None
        )
        return self._distributed.Client(cluster)


def lost(name: str) -> Outcome:
    """The outcome of a job whose workers died."""
    error = f"its worker died {MAX_TRIES} times; is there memory enough for it?"
    return Outcome(name=name, state="failed", error=error)


def make_scheduler(address: str | None, num_workers: int) -> Scheduler:
    """Processes of this machine where no address is given, else a Dask cluster."""
    return Processes(num_workers) if address is None else Dask(address, num_workers)


def bound(call: Callable[..., Outcome], *arguments: Any) -> Call:
    """A call with its arguments, as it is sent to a worker."""
    return partial(call, *arguments)
