"""Scenes of many solids."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.recognition.fitting.ransac import find_solids


def scene(surfaces):
    rng = np.random.default_rng(0)
    table = np.column_stack([rng.uniform(-3, 3, (3000, 2)), np.zeros(3000)])
    ball = np.add(surfaces.ball(rng, 0.6, 900), [1.5, 1.5, 0.8])
    can = np.add(surfaces.frustum(rng, 0.4, 0.4, 1.2, 900), [-1.5, 0.0, 0.2])
    points = np.concatenate([table, ball, can])
    return points + 0.004 * rng.normal(size=points.shape), np.repeat([0, 1, 2], [3000, 900, 900])


def test_table_ball_and_can_are_found(surfaces):
    points, truth = scene(surfaces)
    found = find_solids(points, 200, np.random.default_rng(1))
    kinds = [one.solid.kind for one in found[:3]]
    assert kinds[0] == "plane"
    assert sorted(kinds[1:]) == ["cylinder", "sphere"]
    for one in found[:3]:
        share = np.bincount(truth[one.rows], minlength=3).max() / len(one.rows)
        assert share > 0.97
    radii = {one.solid.kind: one.solid.radius for one in found[1:3]}
    assert radii["sphere"] == pytest.approx(0.6, rel=0.01)
    assert radii["cylinder"] == pytest.approx(0.4, rel=0.01)


def test_same_seed_gives_the_same_solids(surfaces):
    points, _ = scene(surfaces)
    first, second = (find_solids(points, 200, np.random.default_rng(3)) for _ in range(2))
    assert [one.rows.tolist() for one in first] == [one.rows.tolist() for one in second]


def test_no_point_belongs_to_two_solids(surfaces):
    points, _ = scene(surfaces)
    rows = np.concatenate([one.rows for one in find_solids(points, 50, np.random.default_rng(2))])
    assert len(np.unique(rows)) == len(rows)


@pytest.mark.parametrize("count", [0, 1, 5])
def test_too_few_points_give_no_solid(count):
    assert find_solids(np.ones((count, 3)), 3, np.random.default_rng(0)) == []


def test_non_finite_point_is_named():
    points = np.zeros((20, 3))
    points[3, 1] = np.inf
    with pytest.raises(InputError, match="points holds inf at flat index 10"):
        find_solids(points, 3, np.random.default_rng(0))
