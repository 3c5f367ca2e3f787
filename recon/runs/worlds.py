"""Exploration of random worlds, and the rate of correctly named objects."""

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exploration.agent import explore
from recon.recognition.recognition import recognise
from recon.recognition.reliability import calibration_error
from recon.records import FoundObject
from recon.runs.arguments import count
from recon.runs.figures import leave_figure, read_arrays
from recon.runs.job import Job, Kind, Numbers
from recon.runs.work import Work
from recon.settings import EXPLORER_BASE
from recon.world.generator import random_scene
from recon.world.objects import TrueObject
from recon.world.world import World

NOT_FOUND = "not found"
NUM_OBJECTS = 6
GAP = 8.0
"""Minimum free ground between two objects, world units."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedName:
    """One true object and its assigned name."""

    true: str
    found: str
    probability: float


def _worlds(job: Job, work: Work) -> Numbers:
    """Explore random worlds and count labels, by the settings' recogniser and the thesis's."""
    num_worlds: int = job.arguments.get("worlds", 1)
    own: list[JudgedName] = []
    thesis: list[JudgedName] = []
    for number in range(num_worlds):
        by_settings, by_thesis = _explore_one(job, number, work)
        own += by_settings
        thesis += by_thesis
        work.progress(number + 1, num_worlds)
    report: Numbers = {"worlds": num_worlds, "robust": summary(own), "thesis": summary(thesis)}
    if work.folder:
        with work.stage("figures"):
            _leave_figures(work.folder.path, own, thesis)
    return report


def _explore_one(job: Job, number: int, work: Work) -> tuple[list[JudgedName], list[JudgedName]]:
    """Names of the objects of one world by the settings' recogniser and the thesis's."""
    settings = job.settings
    scene = random_scene(np.random.default_rng([job.seed, number]), NUM_OBJECTS, GAP)
    world = World(scene, settings.eyes, settings.render, settings.world)
    done = explore(world, settings, stopwatch=work.stopwatch)
    with work.stage("recognise"):
        chosen = replace(settings.recognition, recogniser="thesis")
        by_thesis = recognise(done.reconstruction.voxels, chosen)
    return (
        judged_names(world.objects, done.recognition.objects),
        judged_names(world.objects, by_thesis.objects),
    )


def _leave_figures(run_path: Path, own: list[JudgedName], thesis: list[JudgedName]) -> None:
    for name, named in (("confusion", own), ("confusion_thesis", thesis)):
        arrays = {
            "true": np.array([one.true for one in named], dtype=np.str_),
            "found": np.array([one.found for one in named], dtype=np.str_),
        }
        leave_figure(run_path, "confusion", arrays, name)
    judged = {
        "probability": np.array([one.probability for one in own]),
        "is_right": np.array([one.found == one.true for one in own]),
    }
    leave_figure(run_path, "reliability", judged)


def judged_names(
    true_objects: tuple[TrueObject, ...], found_objects: tuple[FoundObject, ...]
) -> list[JudgedName]:
    """Every true object with the nearest found one, by axis, within its own half width."""
    return [_judged_name(true, found_objects) for true in true_objects]


def _judged_name(true: TrueObject, found_objects: tuple[FoundObject, ...]) -> JudgedName:
    def distance(found: FoundObject) -> float:
        return float(np.hypot(*(found.centre - true.centre)[[0, 2]]))

    nearest = min(found_objects, key=distance, default=None)
    if nearest is None or distance(nearest) > max(true.size[[0, 2]]) / 2.0:
        return JudgedName(true=true.label, found=NOT_FOUND, probability=0.0)
    return JudgedName(true=true.label, found=nearest.label, probability=nearest.probability or 0.0)


def summary(named: list[JudgedName]) -> dict[str, Any]:
    """Counts of correct labels, and the confusion matrix, true by found."""
    if not named:
        raise InputError("there are no objects to be named; request at least one world")
    confusion: dict[str, Counter[str]] = {}
    for one in named:
        confusion.setdefault(one.true, Counter())[one.found] += 1
    right = sum(one.true == one.found for one in named)
    return {
        "num_objects": len(named),
        "num_right": right,
        "success": 100.0 * right / len(named),
        "calibration_error": calibration_error(
            [one.probability for one in named], [one.true == one.found for one in named]
        ),
        "confusion": {true: dict(sorted(row.items())) for true, row in sorted(confusion.items())},
    }


def _judged(job: Job, run_path: Path) -> list[tuple[str, str]]:
    arrays = read_arrays(run_path / "figures" / "confusion.npz")
    return list(zip(arrays["true"].tolist(), arrays["found"].tolist(), strict=True))


WORLDS = Kind(
    run=_worlds,
    num_inputs=0,
    judged=_judged,
    base=lambda job: EXPLORER_BASE,
    takes={"worlds": count},
    stages=("render", "stereo", "map", "plan", "recognise", "figures"),
)
