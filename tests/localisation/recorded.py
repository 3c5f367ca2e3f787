"""Pairs of the village, taken on a ring around it: every second one is used for a map."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from recon.localisation.atlas import Atlas
from recon.localisation.keeper import PlaceKeeper
from recon.mapping.mapper import Mapper
from recon.records import StereoPair, View, Voxels
from recon.settings import Settings, explorers, updated
from recon.world.world import World

SETTINGS = updated(
    explorers(Settings()),
    {"map": {"min_count": 3, "cell_size": 2.0}, "eyes": {"width": 192, "height": 192}},
)


@dataclass(frozen=True)
class Recorded:
    """A map, its places, and pairs that are not in it, with their true poses."""

    voxels: Voxels
    atlas: Atlas
    others: tuple[StereoPair, ...]


@cache
def village() -> Recorded:
    """Take half of the pairs of a round among the houses, and map the others."""
    world = World.from_file("village", SETTINGS)
    mapper, keeper = Mapper(SETTINGS, compares=False), PlaceKeeper()
    others = []
    for number, angle in enumerate(np.radians(np.arange(0.0, 48.0, 4.0))):
        place = 34.0 * np.array([np.sin(angle), 0.0, np.cos(angle)]) + [0.0, 5.0, 0.0]
        pair = world.take(View(position=place, target=np.array([0.0, 5.0, 0.0])))
        if number % 2:
            others.append(pair)
            continue
        (step,) = mapper.process(
            StereoPair(
                left=pair.left, right=pair.right, rig=pair.rig, T_world_left=pair.T_world_left,
                stamp_s=float(number),
            )
        )  # fmt: skip
        keeper.add(pair, step.number)
    return Recorded(
        voxels=mapper.voxels(), atlas=keeper.atlas(mapper.trajectory), others=tuple(others)
    )
