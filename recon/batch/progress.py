"""Transport of job progress from workers to the observer of the batch."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection, Pipe, wait

from recon.batch.worker import Progress, report_progress_to
from recon.processes import begin_worker

INTERVAL_S = 0.2


class Pipes:
    """A pipe per worker: one that is killed while writing does not disturb the others."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._ends: list[Connection] = []
        self._is_over = threading.Event()

    def new(self) -> Connection:
        """The end for a new worker to write to."""
        read, write = Pipe(duplex=False)
        self._ends.append(read)
        return write

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Forward the workers' messages inside the block; jobs that run after it are cancelled."""
        thread = threading.Thread(target=self._listen, daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._is_over.set()
            thread.join()
            for end in self._ends:
                end.close()

    def _listen(self) -> None:
        while not self._is_over.wait(0.0 if self._pass_on() else INTERVAL_S):
            pass
        while self._pass_on():  # messages written before the end
            pass

    def _pass_on(self) -> bool:
        """Forward one message of each worker that has one; return False if none has."""
        ready = wait(self._ends, timeout=0.0) if self._ends else []
        for end in ready:
            assert isinstance(end, Connection)
            try:
                self._progress(*end.recv())
            except (EOFError, OSError):
                self._ends.remove(end)
        return bool(ready)


def set_up_worker(num_threads: int, end: Connection) -> None:
    """Set up a worker process: its share of the processors, and its progress reports."""
    begin_worker(num_threads)

    def tell(name: str, done: int, total: int) -> None:
        try:
            end.send((name, done, total))
        except OSError as error:
            # The batch was interrupted, of which this process may have had no signal.
            from recon.runs.events import Cancelled

            raise Cancelled from error

    report_progress_to(tell)
