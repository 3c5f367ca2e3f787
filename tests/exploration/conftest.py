"""Exploration without images: points of a world of cylinders replace stereo."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from recon.exploration.agent import Exploration, explore
from recon.mapping import mapper
from recon.settings import Settings, updated
from tests.exploration.flatland import Flatland, in_units

Discs = Sequence[tuple[float, float, float, float]]

DONE: dict[object, Exploration] = {}
"""Explorations that nobody took part in, by their world and settings: they come out alike."""


@pytest.fixture
def explore_discs(monkeypatch) -> Callable[..., Exploration]:
    """Explore cylinders (x, z, radius, height) with some settings of the explorer."""

    def run(
        discs: Discs,
        observe=None,
        take=None,
        led_by=None,
        size: float = 100.0,
        scale: float = 1.0,
        glass: Discs = (),
        **exploration,
    ) -> Exploration:
        changes = {
            "exploration": {"max_pairs": 300, **exploration},
            "world": {"size_x": size, "size_z": size},
        }
        settings = in_units(updated(Settings(), changes), scale)
        world = Flatland(
            discs=scale * np.array(discs).reshape(-1, 4), settings=settings, glass=glass
        )
        key = (tuple(discs), tuple(glass), repr(settings))
        is_alone = not (observe or take or led_by)
        if is_alone and key in DONE:
            return DONE[key]
        monkeypatch.setattr(mapper, "match_points", world.match_points)
        done = explore(world, settings, observe, take, controller=led_by)
        if is_alone:
            DONE[key] = done
        return done

    return run
