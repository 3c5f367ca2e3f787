"""Compilation in advance: of modules, and of kernels by small jobs that need nearly all of them."""

import compileall
import logging
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from recon.runs.events import Events
from recon.runs.execute import execute
from recon.runs.fit import fit_run
from recon.runs.job import Job
from recon.sequences.images import read_image
from recon.sequences.writing import write_image
from recon.settings import Settings, updated
from recon.world.library import find_scene

SCENE, OTHER_SCENE = "village", "three_kinds"
NUM_PAIRS, NUM_OTHER_PAIRS = 4, 10
"""Pairs of an exploration: enough to see objects and plan a path; and to go round one."""

Jobs = list[Callable[[], Any]]


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
    compile_modules(Path(__file__).parents[1])
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
    for job in jobs:
        job()


def _jobs(place: Path) -> Iterator[Jobs]:
    """The jobs of each process."""
    yield [
        _walk(SCENE, NUM_PAIRS, place / "walk"),
        _walk(OTHER_SCENE, NUM_OTHER_PAIRS, place / "other"),
        partial(fit_run, place / "walk/cloud.ply"),
    ]
    surface = updated(Settings(), {"dense": {"enabled": True}, "surface": {"mesh": True}})
    recording = place / "recording"
    seen = recording / "seen.ply"
    named = updated(Settings(), {"recognition": {"catalogue": ["household"]}})
    images = tuple(recording / f"{side}/000000.png" for side in ("left", "right"))
    scene, views = find_scene(SCENE), {"views": "drive:3"}
    again = Job(kind="reconstruct", inputs=(recording,))
    yield [
        partial(execute, Job(kind="render", inputs=(scene,), arguments=views), recording),
        partial(execute, replace(again, settings=surface), place / "run"),
        partial(execute, Job(kind="disparity", inputs=images, settings=surface), place / "matches"),
        partial(execute, Job(kind="recognise", inputs=(seen,), settings=named), place / "named"),
        partial(_turn_grey, recording),
        partial(execute, again, place / "grey"),
    ]


def _walk(scene: str, num_pairs: int, folder: Path) -> Callable[[], Any]:
    settings = updated(Settings(), {"exploration": {"max_pairs": num_pairs}})
    return partial(
        execute, Job(kind="explore", inputs=(find_scene(scene),), settings=settings), folder
    )


def _turn_grey(recording: Path) -> None:
    """Leave its images one channel, for which kernels are compiled apart."""
    for side in ("left", "right"):
        for path in (recording / side).iterdir():
            write_image(path, read_image(path)[..., 1])
