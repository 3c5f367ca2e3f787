"""The explorer in imperfect worlds: noise, sky, another unit, touching and unknown objects.

Every condition is explored in three generated worlds of six objects, with the seeds of this
module; `--quick` uses only the first world. Clean worlds give the reference number of pairs. To
run some rows only, in worlds of other seeds:

    python tools/benchmarks/robustness.py noise_5 touching --seed 205 --seed 206
"""

import dataclasses
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[1]))
from benchmarks import Measurement
from benchmarks.foreign import foreign_scene
from recon.exploration.agent import Exploration, explore
from recon.records import UNKNOWN
from recon.settings import Settings, explorers, updated
from recon.world.generator import random_scene
from recon.world.visuals import CylinderVisual, EllipsoidVisual, PolygonVisual, Scene, SphereVisual
from recon.world.world import World

SEEDS = (102, 103, 104)
NUM_OBJECTS = 6
LENGTHS = {
    "map": ("cell_size",),
    "eyes": ("baseline", "near", "far", "eye_height"),
    "exploration": ("clearance", "walk_clearance", "sight_range", "viewing_distance"),
    "world": ("size_x", "size_z", "height"),
    "recognition": ("ground_clearance",),
    "motion": ("body_radius", "body_height", "position_noise"),
    "render": ("texture_tile",),
}
"""Every setting that is a length, by stage."""


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """Imperfections of a set of worlds."""

    render: dict[str, Any] = dataclasses.field(default_factory=dict)
    """Settings of the renderer."""
    scale: float = 1.0
    """Of every length."""
    gap: float = 8.0
    """Least free ground between two objects, before lengths are scaled."""
    foreign: bool = False
    """True where no catalogue knows what stands there."""


CLEAN = "clean"
CONDITIONS = {
    CLEAN: Condition(),
    "noise_2": Condition(render={"noise": 2.0}),
    "noise_5": Condition(render={"noise": 5.0}),
    "noise_10": Condition(render={"noise": 10.0}),
    "grain_2": Condition(render={"noise": 2.0, "noise_grain_px": 0.8}),
    "grain_5": Condition(render={"noise": 5.0, "noise_grain_px": 0.8}),
    "sky": Condition(render={"sky": True}),
    "noise_2_sky_shading": Condition(render={"noise": 2.0, "sky": True, "shading": True}),
    "tenth": Condition(scale=0.1),
    "tenfold": Condition(scale=10.0),
    "gap_1": Condition(gap=1.0),
    "touching": Condition(gap=0.0),
    "foreign": Condition(foreign=True),
}


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Thing:
    """A true object of a world."""

    label: str
    centre_xz: NDArray[np.float64]
    reach: float
    """Distance from the centre within which it is found."""


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """The objects of a world, and its exploration."""

    things: Sequence[Thing]
    done: Exploration


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Counts of one condition over its worlds."""

    right: int
    false: int
    extra: int
    """Objects found beyond those that are there."""
    pairs: int
    ended: int
    clearance: float
    until_objects: float
    """Path until the objects had their final names, of the oracle's, where that has one."""
    path_share: float
    without_oracle: int
    """Worlds of which the oracle found no tour."""


def measure(quick: bool) -> list[Measurement]:
    """Measure every condition, and the clean worlds."""
    return rows(CONDITIONS, SEEDS[:1] if quick else SEEDS)


def rows(names: Iterable[str], seeds: Sequence[int]) -> list[Measurement]:
    """Measure some conditions in the worlds of some seeds."""
    clean = row_of([explored(seed, CONDITIONS[CLEAN]) for seed in seeds])
    found = list(measurements(CLEAN, clean, clean))
    for name in names:
        if name != CLEAN:
            row = row_of([explored(seed, CONDITIONS[name]) for seed in seeds])
            found += measurements(name, row, clean)
    return found


def settings_with(changes: dict[str, Any]) -> Settings:
    """Make the settings of `recon explore` with some changes."""
    return explorers(updated(Settings(), changes))


def explored(seed: int, condition: Condition) -> Run:
    """Explore a generated world."""
    rng = np.random.default_rng(seed)
    settings = in_units(settings_with({"render": condition.render}), condition.scale)
    if condition.foreign:
        scene, places = foreign_scene(rng, NUM_OBJECTS, condition.gap)
        things = [
            Thing(label=UNKNOWN, centre_xz=np.array([x, z]), reach=reach)
            for x, z, reach in places.found_within
        ]
        world = World(scene, settings.eyes, settings.render, settings.world)
        return Run(things=things, done=explore(world, settings))
    scene = scaled(random_scene(rng, NUM_OBJECTS, condition.gap), condition)
    world = World(scene, settings.eyes, settings.render, settings.world)
    return Run(things=things_of(world), done=explore(world, settings))


def things_of(world: World) -> list[Thing]:
    """List the true objects of a world."""
    return [
        Thing(label=one.label, centre_xz=one.centre[[0, 2]], reach=max(one.size[[0, 2]]) / 2.0)
        for one in world.objects
    ]


def in_units(settings: Settings, scale: float) -> Settings:
    """Scale every length in the settings."""
    lengths = {
        stage: {name: getattr(getattr(settings, stage), name) for name in names}
        for stage, names in LENGTHS.items()
    }
    # Lengths that are None follow from the scaled ones.
    changes = {
        stage: {name: scale * length for name, length in of_stage.items() if length is not None}
        for stage, of_stage in lengths.items()
    }
    return updated(settings, changes)


def scaled(scene: Scene, condition: Condition) -> Scene:
    """Scale every length in a scene."""
    visuals = tuple(_scaled(visual, condition.scale) for visual in scene.visuals)
    return dataclasses.replace(scene, visuals=visuals)


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


def row_of(runs: list[Run]) -> Row:
    """Count what was found in some worlds."""
    named = [labels_of(run) for run in runs]
    metrics = [run.done.metrics for run in runs]
    toured = [one for one in metrics if one["oracle_path"] is not None]
    return Row(
        right=sum(right for right, _ in named),
        false=sum(false for _, false in named),
        extra=sum(max(0, one["num_objects"] - NUM_OBJECTS) for one in metrics),
        pairs=sum(one["num_pairs"] for one in metrics),
        ended=sum(run.done.stop_reason == "all known" for run in runs),
        clearance=min(one["min_clearance"] for one in metrics),
        until_objects=mean([path_until_objects(one) for one in toured]),
        path_share=mean([one["path_length"] / one["oracle_path"] for one in toured]),
        without_oracle=len(metrics) - len(toured),
    )


def mean(shares: Sequence[float]) -> float:
    """Average some shares; NaN for none."""
    return float(np.mean(shares)) if shares else float("nan")


def path_until_objects(metrics: dict[str, Any]) -> float:
    """Path until the objects had their final names, as a share of the oracle's."""
    _, path_length, _ = metrics["curve"][max(metrics["pairs_until_objects"], 1) - 1]
    return float(path_length / metrics["oracle_path"])


def labels_of(run: Run) -> tuple[int, int]:
    """Count correctly labelled objects, and false labels."""
    objects = run.done.recognition.objects
    right, deserved = 0, set()
    for true in run.things:
        apart = [float(np.hypot(*(one.centre[[0, 2]] - true.centre_xz))) for one in objects]
        nearest = int(np.argmin(apart)) if apart else -1
        is_near = nearest >= 0 and apart[nearest] <= true.reach
        if is_near and objects[nearest].label == true.label:
            right += 1
            deserved.add(nearest)
    named = {number for number, one in enumerate(objects) if one.label != UNKNOWN}
    return right, len(named - deserved)


def measurements(condition: str, row: Row, clean: Row) -> Iterator[Measurement]:
    """Make the measurements of one condition."""
    yield number(f"{condition}.named_right", row.right, "objects", "higher")
    yield number(f"{condition}.named_falsely", row.false, "objects")
    yield number(f"{condition}.extra_pieces", row.extra, "objects")
    yield number(f"{condition}.all_known", row.ended, "worlds", "higher")
    yield number(f"{condition}.pairs", row.pairs / clean.pairs, "of the clean worlds'")
    yield number(f"{condition}.clearance", row.clearance, "units", "higher")
    yield number(f"{condition}.path_until_objects", row.until_objects, "of the oracle's")
    yield number(f"{condition}.path", row.path_share, "of the oracle's")
    yield number(f"{condition}.without_oracle", row.without_oracle, "worlds")


def number(name: str, value: float, unit: str, better: str = "lower") -> Measurement:
    """Make a measurement of this topic."""
    return Measurement(
        name=f"robustness.{name}", value=float(value), unit=unit, better=better, tolerance=0.25
    )


@click.command()
@click.argument("names", nargs=-1, type=click.Choice(list(CONDITIONS)))
@click.option("--seed", "seeds", multiple=True, type=int, default=SEEDS, show_default=True)
def main(names: tuple[str, ...], seeds: tuple[int, ...]) -> None:
    """Print the results of some conditions, and of the clean worlds."""
    for one in rows(names, seeds):
        print(f"{one.name:44} {one.value:12.4g} {one.unit}")


if __name__ == "__main__":
    main()
