"""Compilation in advance: of modules, and of kernels by small jobs that need all of them."""

import compileall
import logging
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

import recon
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
    """Compile all modules, and run small jobs in a temporary folder, in two processes.

    Numba caches what the jobs compile.

    Parameters
    ----------
    events : Events, optional
        Notified when a process is done.
    """
    events = events or Events()
    events.on_stage("compiling")
    compile_modules(Path(recon.__file__).parent)
    with (
        tempfile.TemporaryDirectory(prefix="recon-") as name,
        ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool,
    ):
        futures = [pool.submit(_run, jobs) for jobs in _jobs(Path(name))]
        for number, future in enumerate(as_completed(futures), start=1):
            future.result()
            events.progress(number, len(futures))


def compile_modules(package: Path) -> None:
    """Write the bytecode of a package, if its folder can be written.

    With PYTHONDONTWRITEBYTECODE, common in containers, every start would compile all that it loads.
    """
    compileall.compile_dir(package, quiet=2)


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
