"""Occupancy rules: each keeps and drops the right cells."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.settings import MapSettings
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import RULES, new_map, occupied
from tests.voxelmap.clouds import cloud

ORIGIN = [0.5, 0.5, 0.5]


def kept(settings, scans):
    voxel_map = new_map(settings)
    for points, view in scans:
        voxel_map.insert(points, ORIGIN, view)
    return occupied(voxel_map, settings).index[:, 0].tolist()


def points_at(x, num, sigma=0.01):
    return cloud([[x + 0.5, 0.5, 0.5]] * num, sigma=np.full(num, sigma))


def test_table_has_every_rule_of_the_settings():
    assert set(RULES) == {"count", "weight", "carving", "log-odds", "views"}


def test_count():
    scans = [(points_at(3, 5), 0), (points_at(5, 4), 0)]
    assert kept(MapSettings(), scans) == [3]
    assert kept(MapSettings(min_count=4), scans) == [3, 5]


def test_weight_prefers_few_accurate_points_to_many_uncertain_ones():
    scans = [(points_at(3, 3, sigma=0.03), 0), (points_at(5, 30, sigma=3.0), 0)]
    assert kept(MapSettings(occupancy=("weight",)), scans) == [3]
    assert kept(MapSettings(occupancy=("weight",), min_weight=0.2), scans) == [3, 5]


def test_carving_removes_cells_that_rays_passed_through():
    ghost, wall = points_at(5, 4), points_at(9, 4)
    scans = [(ghost, 0)] + [(wall, view) for view in range(1, 9)]
    assert kept(MapSettings(occupancy=("carving",)), scans) == [9]
    assert kept(MapSettings(occupancy=("carving",), min_hit_share=0.1), scans) == [5, 9]
    assert kept(MapSettings(occupancy=("count",), min_count=4), scans) == [5, 9]


def test_log_odds_weigh_hits_against_passes():
    near, far = points_at(5, 1), points_at(9, 1)
    scans = [(near, 0), (far, 1), (far, 2)]
    assert kept(MapSettings(occupancy=("log-odds",)), scans) == [5, 9]
    assert kept(MapSettings(occupancy=("log-odds",)), [*scans, (far, 3)]) == [9]


def test_views_rule_counts_distinct_views():
    scans = [(points_at(3, 9), 4), (points_at(5, 1), 4), (points_at(5, 1), 6)]
    assert kept(MapSettings(occupancy=("views",)), scans) == [5]


def test_all_given_rules_must_hold():
    scans = [(points_at(3, 5), 0), (points_at(3, 5), 1), (points_at(5, 9), 1)]
    assert kept(MapSettings(occupancy=("count", "views")), scans) == [3]


def test_rule_names_the_missing_channel():
    with pytest.raises(InputError, match="the map keeps no channels, but weight is needed"):
        occupied(VoxelMap(), MapSettings(occupancy=("weight",)))
