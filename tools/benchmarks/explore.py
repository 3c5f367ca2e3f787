"""The explorer in the village and in random worlds, with real rendering and matching."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import Measurement
from recon.exploration.agent import explore
from recon.exploration.outcome import Exploration
from recon.runs.worlds import judged_names
from recon.settings import Settings, explorers, updated
from recon.world.generator import random_scene
from recon.world.world import World

SCENES = Path(__file__).parents[2] / "scenes"
VILLAGE, SQUARE = SCENES / "village.scene", SCENES / "square.scene"
COUNTS = (3, 4, 5, 6, 8, 9, 10, 12)
GAPS = (22.0, 4.0, 12.0, 6.0, 16.0, 4.0, 8.0, 5.0, 10.0, 14.0, 4.0)


def measure(quick: bool) -> list[Measurement]:
    """Compare the costs of the frontier controller with the thesis's, at the same completeness."""
    return [*village(), square(), *random_worlds(2 if quick else 20)]


def settings_for(controller: str) -> Settings:
    """Make the settings of `recon explore`."""
    return explorers(updated(Settings(), {"exploration": {"controller": controller}}))


def village() -> Iterator[Measurement]:
    """Compare pairs, coverage and path with the thesis's controller."""
    runs = {}
    for controller in ("frontier", "thesis"):
        settings = settings_for(controller)
        runs[controller] = explore(World.from_file(VILLAGE, settings), settings).metrics
    frontier, thesis = runs["frontier"], runs["thesis"]
    yield number("village_pairs_until_objects", frontier["pairs_until_objects"], "pairs (bar 60)")
    yield number("village_pairs", frontier["num_pairs"], "pairs")
    for name, bar, better in (("coverage", "0.95", "higher"), ("path_length", "0.7", "lower")):
        share = frontier[name] / thesis[name]
        yield number(f"village_{name}_share", share, f"of the thesis's (bar {bar})", better)


def square() -> Measurement:
    """Count correctly labelled objects in the scene of houses, benches and lamp posts."""
    settings = settings_for("frontier")
    world = World.from_file(SQUARE, settings)
    done = explore(world, settings)
    right = sum(
        one.true == one.found for one in judged_names(world.objects, done.recognition.objects)
    )
    return number("square_right", right, f"of {len(world.objects)} objects", "higher")


def random_worlds(count: int) -> Iterator[Measurement]:
    """Explore worlds of 3 to 12 objects, with gaps from 22 down to 4 units."""
    settings = settings_for("frontier")
    lost, clearance, unended = 0, np.inf, 0
    for seed in range(count):
        world = world_of(seed, settings)
        done = explore(world, settings)
        lost += sum(not is_found(done, true) for true in world.objects)
        clearance = min(clearance, done.metrics["min_clearance"])
        unended += done.stop_reason != "all known"
    yield number(f"random_{count}_objects_lost", lost, "objects (bar 0)")
    yield number(f"random_{count}_min_clearance", clearance, "units (bar 1)", "higher")
    yield number(f"random_{count}_not_all_known", unended, "worlds")


def world_of(seed: int, settings: Settings) -> World:
    """Make a random world; the gap is reduced if the objects do not fit."""
    rng = np.random.default_rng(seed)
    count, gap = COUNTS[seed % len(COUNTS)], GAPS[seed % len(GAPS)]
    scene = random_scene(rng, count, min(gap, 60.0 / count))
    return World(scene, settings.eyes, settings.render, settings.world)


def is_found(done: Exploration, true: Any) -> bool:
    """True if an object of the right label is within one unit of a true one."""
    return any(
        found.label == true.label and np.linalg.norm((found.centre - true.centre)[[0, 2]]) < 1.0
        for found in done.recognition.objects
    )


def number(name: str, value: float, unit: str, better: str = "lower") -> Measurement:
    """Make a measurement of this topic."""
    return Measurement(
        name=f"explore.{name}", value=float(value), unit=unit, better=better, tolerance=0.25
    )
