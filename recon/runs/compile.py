"""Kernels compiled ahead: small jobs that between them need all of them."""

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from recon.runs.events import Events
from recon.runs.execute import execute
from recon.runs.job import Job
from recon.settings import Settings, updated
from recon.world.library import find_scene

SCENE = "village"
NUM_PAIRS = 4
"""Of a walk: so many let objects be seen, and the way be planned."""


def compile_ahead(events: Events | None = None) -> None:
    """Do the small jobs in a folder that is removed; numba keeps what they compile.

    Parameters
    ----------
    events : Events, optional
        Told of every job that is done.
    """
    events = events or Events()
    with tempfile.TemporaryDirectory(prefix="recon-") as name:
        jobs = [*_jobs(Path(name))]
        for number, (job, folder) in enumerate(jobs):
            events.on_stage(job.kind)
            execute(job, folder, replace(events, on_progress=Events().on_progress))
            events.progress(number + 1, len(jobs))


def _jobs(place: Path) -> Iterator[tuple[Job, Path]]:
    """Every job, and the run folder that it leaves."""
    scene = find_scene(SCENE)
    walk = updated(Settings(), {"exploration": {"max_pairs": NUM_PAIRS}})
    surface = updated(Settings(), {"dense": {"enabled": True}, "surface": {"mesh": True}})
    recording, pair = place / "recording", ("left/000000.png", "right/000000.png")
    yield Job(kind="explore", inputs=(scene,), settings=walk), place / "walk"
    yield Job(kind="render", inputs=(scene,), arguments={"views": "drive:3"}), recording
    yield Job(kind="reconstruct", inputs=(recording,), settings=surface), place / "run"
    images = tuple(recording / image for image in pair)
    yield Job(kind="disparity", inputs=images, settings=surface), place / "matches"
