"""The explorer where worlds are less than perfect: noise, grain, sky, shading, another unit.

Every condition is explored in three generated worlds of six objects, whose seeds are the module's
own; `--quick` takes the first world only. The clean world beside it gives the pairs.
"""

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks import Measurement
from recon.exploration.agent import Exploration, explore
from recon.records import UNKNOWN
from recon.settings import EXPLORER_BASE, Settings, merged, updated, with_quality
from recon.world.generator import random_scene
from recon.world.visuals import CylinderVisual, EllipsoidVisual, PolygonVisual, Scene, SphereVisual
from recon.world.world import World

SEEDS = (102, 103, 104)
NUM_OBJECTS, GAP = 6, 8.0
CONDITIONS: dict[str, dict[str, Any]] = {
    "noise_2": {"noise": 2.0},
    "noise_5": {"noise": 5.0},
    "noise_10": {"noise": 10.0},
    "grain_2": {"noise": 2.0, "noise_grain_px": 0.8},
    "grain_5": {"noise": 5.0, "noise_grain_px": 0.8},
    "sky": {"sky": True},
    "noise_2_sky_shading": {"noise": 2.0, "sky": True, "shading": True},
}
"""Settings of the renderer by condition."""
SCALES = {"tenth": 0.1, "tenfold": 10.0}
LENGTHS = {
    "map": ("cell_size",),
    "eyes": ("baseline", "near", "far", "eye_height"),
    "exploration": ("clearance", "walk_clearance", "sight_range", "viewing_distance"),
    "world": ("size_x", "size_z", "height"),
    "recognition": ("ground_clearance",),
    "motion": ("body_radius", "body_height"),
    "render": ("texture_tile",),
}
"""Every setting that is a length, by stage."""


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Counts of one condition over its worlds."""

    right: int
    false: int
    pairs: int
    ended: int
    clearance: float
    path_share: float


def measure(quick: bool) -> list[Measurement]:
    """Numbers of every condition, and of the clean worlds."""
    seeds = SEEDS[:1] if quick else SEEDS
    clean = row_of([explored(seed, {}) for seed in seeds])
    found = list(measurements("clean", clean, clean))
    for name, render in CONDITIONS.items():
        row = row_of([explored(seed, {"render": render}) for seed in seeds])
        found += measurements(name, row, clean)
    for name, scale in SCALES.items():
        row = row_of([explored(seed, {}, scale) for seed in seeds])
        found += measurements(name, row, clean)
    return found


def settings_with(changes: dict[str, Any]) -> Settings:
    """The settings of `recon explore` with some changes."""
    return updated(with_quality(Settings(), "fast"), merged(EXPLORER_BASE, changes))


def explored(seed: int, changes: dict[str, Any], scale: float = 1.0) -> tuple[World, Exploration]:
    """A generated world, and its exploration."""
    scene = random_scene(np.random.default_rng(seed), NUM_OBJECTS, GAP)
    settings = in_units(settings_with(changes), scale)
    world = World(scaled(scene, scale), settings.eyes, settings.render, settings.world)
    return world, explore(world, settings)


def in_units(settings: Settings, scale: float) -> Settings:
    """The settings with every length scaled."""
    changes = {
        stage: {name: scale * getattr(getattr(settings, stage), name) for name in names}
        for stage, names in LENGTHS.items()
    }
    return updated(settings, changes)


def scaled(scene: Scene, scale: float) -> Scene:
    """The scene with every length scaled."""
    return dataclasses.replace(scene, visuals=tuple(_scaled(v, scale) for v in scene.visuals))


def _scaled(visual: Any, scale: float) -> Any:
    if isinstance(visual, PolygonVisual):
        vertices = tuple(
            dataclasses.replace(v, position=tuple(scale * x for x in v.position))
            for v in visual.vertices
        )
        return dataclasses.replace(visual, vertices=vertices)
    names = {
        SphereVisual: ("centre", "radius"),
        EllipsoidVisual: ("centre", "radii"),
        CylinderVisual: ("radius_base", "radius_top", "height", "translation"),
    }[type(visual)]
    values = {name: getattr(visual, name) for name in names}
    return dataclasses.replace(
        visual,
        **{
            name: tuple(scale * x for x in value) if isinstance(value, tuple) else scale * value
            for name, value in values.items()
        },
    )


def row_of(runs: list[tuple[World, Exploration]]) -> Row:
    """Count what was found in some worlds."""
    named = [labels_of(world, done) for world, done in runs]
    metrics = [done.metrics for _, done in runs]
    return Row(
        right=sum(right for right, _ in named),
        false=sum(false for _, false in named),
        pairs=sum(one["num_pairs"] for one in metrics),
        ended=sum(done.stop_reason == "all known" for _, done in runs),
        clearance=min(one["min_clearance"] for one in metrics),
        path_share=float(np.mean([one["path_length"] / one["oracle_path"] for one in metrics])),
    )


def labels_of(world: World, done: Exploration) -> tuple[int, int]:
    """Number of objects that are named rightly, and of names that nothing there deserves."""
    objects = done.recognition.objects
    right, deserved = 0, set()
    for true in world.objects:
        apart = [float(np.hypot(*(one.centre - true.centre)[[0, 2]])) for one in objects]
        nearest = int(np.argmin(apart)) if apart else -1
        is_near = nearest >= 0 and apart[nearest] <= max(true.size[[0, 2]]) / 2.0
        if is_near and objects[nearest].label == true.label:
            right += 1
            deserved.add(nearest)
    named = {number for number, one in enumerate(objects) if one.label != UNKNOWN}
    return right, len(named - deserved)


def measurements(condition: str, row: Row, clean: Row) -> Iterator[Measurement]:
    """The numbers of one condition."""
    yield number(f"{condition}.named_right", row.right, "objects", "higher")
    yield number(f"{condition}.named_falsely", row.false, "objects")
    yield number(f"{condition}.all_known", row.ended, "worlds", "higher")
    yield number(f"{condition}.pairs", row.pairs / clean.pairs, "of the clean worlds'")
    yield number(f"{condition}.clearance", row.clearance, "units", "higher")
    yield number(f"{condition}.path", row.path_share, "of the oracle's")


def number(name: str, value: float, unit: str, better: str = "lower") -> Measurement:
    """A measurement of this room."""
    return Measurement(
        name=f"robustness.{name}", value=float(value), unit=unit, better=better, tolerance=0.25
    )
