"""An exploration controlled by a visitor: step, run, pause, stop; it continues without a page."""

import logging
import shutil
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, ReconError
from recon.libraries import return_memory
from recon.records import FoundObject
from recon.runs.job import Job
from recon.runs.report import Report
from recon.settings import Settings

if TYPE_CHECKING:
    from recon.exploration.outcome import Step
    from recon.mapping.mapper import Step as MappedStep

log = logging.getLogger(__name__)

Array = NDArray[np.float64]

PATIENCE_S = 10.0
"""Time for a controller to stop; then it is abandoned."""


class Walk:
    """One exploration in its own thread."""

    def __init__(self, scene: Path, settings: Settings) -> None:
        self.job = Job(kind="explore", inputs=(scene,), settings=settings)
        # Removed at the latest when the program ends.
        self._holder = tempfile.TemporaryDirectory(prefix="recon-", ignore_cleanup_errors=True)
        self.folder = Path(self._holder.name) / scene.stem
        self.number = 0
        """Number of pairs taken."""
        self.objects: tuple[FoundObject, ...] = ()
        self.positions: list[Array] = []
        self.last: Step | None = None
        self.cells: dict[tuple[int, int, int], tuple[int, int, int]] = {}
        """Cells with points so far, with a colour each."""
        self.said = ""
        self.stage = ""
        self._stage_began = time.monotonic()
        self.error = ""
        self.report: Report | None = None
        self._permits = 0
        self._is_free = False
        self._cancelled_at: float | None = None
        self._is_left_behind = False
        self._wakes = threading.Condition()
        self._thread = threading.Thread(target=self._go, daemon=True, name="recon walk")

    @property
    def state(self) -> str:
        """new, running, paused, stopping, failed or done."""
        if self.error:
            return "failed"
        if self.report is not None:
            return "done"
        if self._cancelled_at is not None:
            return "stopping"
        if self._thread.ident is None:
            return "new"
        return "running" if self._is_free or self._permits > 0 else "paused"

    @property
    def is_over(self) -> bool:
        """True if the exploration has ended."""
        return self.state in ("failed", "done")

    def step(self) -> None:
        """Take one more pair."""
        with self._wakes:
            self._is_free = False
            self._permits += 1
            self._wakes.notify_all()
        self._start()

    def run(self) -> None:
        """Continue until the end."""
        with self._wakes:
            self._is_free = True
            self._wakes.notify_all()
        self._start()

    def pause(self) -> None:
        """Pause after the current pair."""
        with self._wakes:
            self._is_free, self._permits = False, 0

    def stop(self) -> None:
        """End after the current pair; the results are kept."""
        with self._wakes:
            self._cancelled_at = self._cancelled_at or time.monotonic()
            self._wakes.notify_all()
        if self._thread.ident is None:
            self.error = "stopped before the first pair"

    def check(self) -> None:
        """Abandon a controller that does not respond; the time it compiles does not count."""
        if self._cancelled_at is None or self.is_over or self.stage not in ("", "plan", "render"):
            return
        if min(time.monotonic() - self._cancelled_at, self.waited_s) > PATIENCE_S:
            self._is_left_behind = True
            self.error = f"the controller has not answered for {PATIENCE_S:g} s; it is abandoned"

    def save(self, target: Path) -> None:
        """Copy the run folder.

        Raises
        ------
        InputError
            If there is no finished run, or the target exists.
        """
        if self.report is None:
            raise InputError("the run is not finished; stop it or let it end, then save it")
        if target.exists():
            raise InputError(f"{target} exists; give another name")
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copytree(self.folder, target)

    def discard(self) -> None:
        """Delete the temporary folder of the run."""
        self._holder.cleanup()

    def _start(self) -> None:
        if self._thread.ident is None:
            self._thread.start()

    @property
    def waited_s(self) -> float:
        """Seconds since the stage began."""
        return time.monotonic() - self._stage_began

    def _go(self) -> None:
        # Late: the page need not wait for the libraries of the exploration.
        from recon.runs.events import Events
        from recon.runs.execute import execute

        events = Events(
            on_step=self._on_step, on_stage=self._on_stage,
            is_cancelled=lambda: self._cancelled_at is not None,
        )  # fmt: skip
        try:
            report = execute(self.job, self.folder, events)
        except (ReconError, OSError) as error:
            self._fail(str(error))
        except KeyboardInterrupt:
            self._fail("stopped")
        # A plug-in may raise anything; the page stays.
        except Exception as error:
            log.exception("the exploration failed")
            self._fail(f"{type(error).__name__}: {error}")
        else:
            if not self._is_left_behind:
                self.objects = report.objects
                self.report = report
        return_memory()

    def _fail(self, text: str) -> None:
        if not self._is_left_behind:
            self.error = text

    def _on_stage(self, name: str) -> None:
        self.stage, self._stage_began = name, time.monotonic()

    def _on_step(self, mapped: "MappedStep") -> None:
        step = cast("Step", mapped)
        self.number = step.number + 1
        self.last = step
        self.objects = tuple(replace(found, id=number) for number, found in enumerate(step.objects))
        self.said = step.said
        self.positions.append(step.view.position)
        self._grow(step)
        with self._wakes:
            self._permits = max(self._permits - 1, 0)
            self._wakes.wait_for(
                lambda: self._is_free or self._permits > 0 or self._cancelled_at is not None
            )

    def _grow(self, step: "Step") -> None:
        settings = self.job.settings.map
        size, cloud = settings.cell_size, step.cloud
        if settings.max_sigma is not None and cloud.sigma is not None:
            # Only points precise enough for the map.
            cloud = cloud.select(cloud.sigma <= settings.max_sigma * size)
        index = np.floor(cloud.points / size).astype(np.int64)
        cells, rows = np.unique(index, axis=0, return_index=True)
        colours = cloud.colours
        chosen = np.full((len(rows), 3), 128) if colours is None else colours[rows]
        for cell, colour in zip(cells.tolist(), chosen.tolist(), strict=True):
            self.cells.setdefault(tuple(cell), tuple(colour))
