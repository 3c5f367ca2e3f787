"""Explorers without images: points of a world of cylinders in place of stereo."""

from collections.abc import Callable, Sequence

import pytest

from recon.exploration.agent import Exploration, explore
from recon.mapping import mapper
from recon.settings import Settings, updated
from tests.exploration.flatland import Flatland


@pytest.fixture
def explore_discs(monkeypatch) -> Callable[..., Exploration]:
    """Explore cylinders (x, z, radius, height) with some settings of the explorer."""

    def run(
        discs: Sequence[tuple[float, float, float, float]],
        observe=None,
        take=None,
        size: float = 120.0,
        **exploration,
    ) -> Exploration:
        changes = {
            "exploration": {"max_pairs": 300, **exploration},
            "world": {"size_x": size, "size_z": size},
        }
        settings = updated(Settings(), changes)
        world = Flatland(discs=discs, settings=settings)
        monkeypatch.setattr(mapper, "match_points", world.match_points)
        return explore(world, settings, observe, take)

    return run
