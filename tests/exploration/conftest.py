"""Explorers without images: points of a world of cylinders in place of stereo."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from recon.exploration.agent import Exploration, explore
from recon.mapping import mapper
from recon.settings import Settings, updated
from tests.exploration.flatland import Flatland, in_units


@pytest.fixture
def explore_discs(monkeypatch) -> Callable[..., Exploration]:
    """Explore cylinders (x, z, radius, height) with some settings of the explorer."""

    def run(
        discs: Sequence[tuple[float, float, float, float]],
        observe=None,
        take=None,
        led_by=None,
        size: float = 120.0,
        scale: float = 1.0,
        glass: Sequence[tuple[float, float, float, float]] = (),
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
        monkeypatch.setattr(mapper, "match_points", world.match_points)
        return explore(world, settings, observe, take, controller=led_by)

    return run
