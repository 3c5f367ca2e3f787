"""The whole pipeline, from rendered pairs to named objects, in the thesis's village."""

from pathlib import Path

import numpy as np

from recon.exploration.agent import explore
from recon.settings import Settings, updated, with_quality
from recon.world.world import World

VILLAGE = Path(__file__).parents[2] / "scenes" / "village.scene"


def test_village_is_explored_and_named_without_collision():
    search = {"matching": {"min_disparity": -10, "max_disparity": 20}}
    settings = updated(with_quality(Settings(), "fast"), search)
    world = World.from_file(VILLAGE, settings)
    done = explore(world, settings)
    assert done.stop_reason == "all known"
    for true in world.objects:
        near = min(
            done.recognition.objects,
            key=lambda found, true=true: np.linalg.norm((found.centre - true.centre)[[0, 2]]),
        )
        assert near.label == true.label
        assert np.linalg.norm((near.centre - true.centre)[[0, 2]]) < 1.0
    assert len(done.recognition.objects) == len(world.objects) == 6
    assert done.metrics["pairs_until_objects"] <= 45
    assert 0.98 < done.metrics["coverage"] <= 1.0
    assert done.metrics["min_clearance"] > 1.0
    oracle = done.metrics["oracle_path"]
    assert done.metrics["path_bound"] < oracle < done.metrics["path_length"] < 2.2 * oracle
