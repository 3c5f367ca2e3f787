"""Compilation of kernels in advance, by small jobs that together need all of them."""

import logging
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

from recon.runs.events import Events
from recon.runs.execute import execute
from recon.runs.job import Job
from recon.settings import Settings, updated
from recon.world.library import find_scene

SCENE = "village"
NUM_PAIRS = 4
"""Pairs of an exploration: enough to see objects and plan a path."""

Jobs = list[tuple[Job, Path]]
"""Jobs, each with its run folder."""


def compile_ahead(events: Events | None = None) -> None:
    """Run small jobs in a temporary folder, in two processes; numba caches what they compile.

    Parameters
    ----------
    events : Events, optional
        Notified when a process is done.
    """
    events = events or Events()
    events.on_stage("compiling")
    with (
        tempfile.TemporaryDirectory(prefix="recon-") as name,
        ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool,
    ):
        futures = [pool.submit(_run, jobs) for jobs in _jobs(Path(name))]
        for number, future in enumerate(as_completed(futures), start=1):
            future.result()
            events.progress(number, len(futures))


def _run(jobs: Jobs) -> None:
    # Warnings of these recordings are of no interest to the user.
    logging.getLogger("recon").setLevel(logging.ERROR)
    for job, folder in jobs:
        execute(job, folder)


def _jobs(place: Path) -> Iterator[Jobs]:
    """The jobs of each process."""
    scene = find_scene(SCENE)
    walk = updated(Settings(), {"exploration": {"max_pairs": NUM_PAIRS}})
    yield [(Job(kind="explore", inputs=(scene,), settings=walk), place / "walk")]
    surface = updated(Settings(), {"dense": {"enabled": True}, "surface": {"mesh": True}})
    recording = place / "recording"
    named = updated(Settings(), {"recognition": {"catalogue": ["household"]}})
    images = tuple(recording / f"{side}/000000.png" for side in ("left", "right"))
    yield [
        (Job(kind="render", inputs=(scene,), arguments={"views": "drive:3"}), recording),
        (Job(kind="reconstruct", inputs=(recording,), settings=surface), place / "run"),
        (Job(kind="disparity", inputs=images, settings=surface), place / "matches"),
        (Job(kind="recognise", inputs=(recording / "seen.ply",), settings=named), place / "named"),
    ]
