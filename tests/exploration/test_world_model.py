"""The agent's model of the world: when obstacles are recognised again."""

from types import SimpleNamespace

import numpy as np
import pytest

from recon.exploration.obstacles import Obstacle
from recon.exploration.world_model import WorldModel, _is_due
from recon.records import UNKNOWN, PointCloud
from recon.settings import Settings
from recon.voxelmap.occupancy import new_map

AROUND, IN_FRONT = (0.0, 2.1, 4.2), (0.0, 0.5, 1.0)


def obstacle(num_cells, bearings, label="house", nearest=()):
    """Make an obstacle that was named when it had 100 cells, after three views."""
    none = np.empty((0, 2), dtype=np.intp)
    return Obstacle(
        cells=none,
        covered=none,
        centre=np.zeros(2),
        radius=3.0,
        top=5.0,
        voxels=range(num_cells),
        bearings_rad=np.array(bearings),
        away=np.zeros(len(bearings)),
        is_whole=np.ones(len(bearings), dtype=bool),
        found=SimpleNamespace(label=label, probability=0.95, nearest=nearest),
        num_named=100,
        views_named=3,
    )


@pytest.mark.parametrize(
    ("num_cells", "bearings", "label", "is_due"),
    [
        (130, IN_FRONT, "house", False),
        (210, IN_FRONT, "house", True),
        (130, AROUND, "house", True),
        (120, AROUND, "house", True),
        (110, AROUND, "house", False),
        (130, IN_FRONT, UNKNOWN, True),
        (210, IN_FRONT[:2], UNKNOWN, False),
    ],
)
def test_obstacle_is_recognised_again_as_it_grows(num_cells, bearings, label, is_due):
    assert _is_due(obstacle(num_cells, bearings, label)) == is_due


@pytest.mark.parametrize(("chance", "is_due"), [(0.4, True), (0.02, False)])
def test_doubtful_obstacle_is_recognised_again_after_every_view(chance, is_due):
    nearest = (("cottage", chance),)
    assert _is_due(obstacle(110, (*AROUND, 1.0), UNKNOWN, nearest)) == is_due
    assert not _is_due(obstacle(110, AROUND, UNKNOWN, nearest))


@pytest.mark.parametrize(("label", "is_due"), [(UNKNOWN, True), ("house", False)])
def test_obstacle_without_a_name_is_recognised_again_when_seen_from_all_around(label, is_due):
    all_round = tuple(np.radians([0.0, 90.0, 180.0, 270.0]))
    assert _is_due(obstacle(110, all_round, label)) == is_due
    assert not _is_due(obstacle(110, all_round[:3], label))


@pytest.mark.parametrize("height", [1, 2, 3, 20])
def test_one_or_two_isolated_cells_do_not_occupy_the_floor(height):
    settings = Settings()
    model = WorldModel(settings=settings, voxel_map=new_map(settings.map))
    stack = np.column_stack([np.zeros(height), 2.0 + np.arange(height), np.full(height, -3.0)])
    points = PointCloud(points=np.repeat(stack + 0.5, settings.map.min_count, axis=0))
    model.voxel_map.insert(points)
    model._find_obstacles(points)
    assert len(model.obstacles) == (height >= settings.recognition.min_voxels)
    assert model.floor.occupied.sum() == (height >= 3)
    assert model.columns.under.sum() == 1
