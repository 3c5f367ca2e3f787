"""Compilation of kernels in advance, by small jobs that together need all of them."""

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
"""Pairs of an exploration: enough to see objects and plan a path."""


def compile_ahead(events: Events | None = None) -> None:
    """Run the small jobs in a temporary folder; numba caches the compiled kernels.

    Parameters
    ----------
    events : Events, optional
        Notified of every finished job.
    """
    events = events or Events()
    with tempfile.TemporaryDirectory(prefix="recon-") as name:
        jobs = [*_jobs(Path(name))]
        for number, (job, folder) in enumerate(jobs):
            events.on_stage(job.kind)
            execute(job, folder, replace(events, on_progress=Events().on_progress))
            events.progress(number + 1, len(jobs))


def _jobs(place: Path) -> Iterator[tuple[Job, Path]]:
    """Every job, and its run folder."""
    scene = find_scene(SCENE)
    walk = updated(Settings(), {"exploration": {"max_pairs": NUM_PAIRS}})
    surface = updated(Settings(), {"dense": {"enabled": True}, "surface": {"mesh": True}})
    recording, pair = place / "recording", ("left/000000.png", "right/000000.png")
    yield Job(kind="explore", inputs=(scene,), settings=walk), place / "walk"
    yield Job(kind="render", inputs=(scene,), arguments={"views": "drive:3"}), recording
    yield Job(kind="reconstruct", inputs=(recording,), settings=surface), place / "run"
    images = tuple(recording / image for image in pair)
    yield Job(kind="disparity", inputs=images, settings=surface), place / "matches"
