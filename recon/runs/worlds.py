"""Random worlds explored end to end, and how often what was found has its right name."""

from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exploration.agent import explore
from recon.figures.confusion import confusion_matrix, reliability
from recon.recognition import recognise
from recon.records import FoundObject
from recon.runs.figures import write_figures
from recon.runs.order import Progress, RunOrder, unwatched
from recon.settings import Settings
from recon.voxelmap.occupancy import occupied
from recon.world.generator import random_scene
from recon.world.objects import TrueObject
from recon.world.world import World

NOT_FOUND = "not found"
NUM_OBJECTS = 6
GAP = 8.0
"""Least free ground between two objects, world units."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Naming:
    """What one true object was taken for."""

    true: str
    found: str
    probability: float


def worlds_run(
    num_worlds: int,
    settings: Settings,
    *,
    seed: int = 0,
    order: RunOrder | None = None,
    progress: Progress = unwatched,
) -> dict[str, Any]:
    """Explore random worlds and count labels, by the recogniser of the settings and the thesis's.

    Returns
    -------
    dict
        For either recogniser the share of right labels and the confusion, true by found.
    """
    run = order and order.folder("evaluate", settings, ())
    own: list[Naming] = []
    thesis: list[Naming] = []
    for number in range(num_worlds):
        scene = random_scene(np.random.default_rng([seed, number]), NUM_OBJECTS, GAP)
        world = World(scene, settings.eyes, settings.render, settings.world)
        done = explore(world, settings)
        voxels = occupied(done.voxel_map, settings.map)
        by_thesis = recognise(voxels, replace(settings.recognition, recogniser="thesis"))
        own += namings(world.objects, done.recognition.objects)
        thesis += namings(world.objects, by_thesis.objects)
        progress(number + 1, num_worlds)
    report: dict[str, Any] = {"worlds": num_worlds, "robust": tally(own), "thesis": tally(thesis)}
    if run:
        with run.opened():
            run.write_json("metrics.json", report)
            write_figures(
                run.path,
                {
                    "confusion": confusion_matrix(report["robust"]["confusion"]),
                    "confusion_thesis": confusion_matrix(report["thesis"]["confusion"]),
                    "reliability": reliability(
                        np.array([one.probability for one in own]),
                        np.array([one.found == one.true for one in own]),
                    ),
                },
            )
    return report


def namings(
    true_objects: tuple[TrueObject, ...], found_objects: tuple[FoundObject, ...]
) -> list[Naming]:
    """Every true object with the found one whose axis is nearest, within its own half width."""
    return [_naming(true, found_objects) for true in true_objects]


def _naming(true: TrueObject, found_objects: tuple[FoundObject, ...]) -> Naming:
    def distance(found: FoundObject) -> float:
        return float(np.hypot(*(found.centre - true.centre)[[0, 2]]))

    nearest = min(found_objects, key=distance, default=None)
    if nearest is None or distance(nearest) > max(true.size[[0, 2]]) / 2.0:
        return Naming(true=true.label, found=NOT_FOUND, probability=0.0)
    return Naming(true=true.label, found=nearest.label, probability=nearest.probability)


def tally(named: list[Naming]) -> dict[str, Any]:
    """Counts of right labels and the confusion, true by found."""
    if not named:
        raise InputError("no object was there to be named; ask for at least one world")
    confusion: dict[str, Counter[str]] = {}
    for one in named:
        confusion.setdefault(one.true, Counter())[one.found] += 1
    right = sum(one.true == one.found for one in named)
    return {
        "num_objects": len(named),
        "num_right": right,
        "success": 100.0 * right / len(named),
        "confusion": {true: dict(sorted(row.items())) for true, row in sorted(confusion.items())},
    }
