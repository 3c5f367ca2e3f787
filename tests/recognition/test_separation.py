"""Objects that nearly touch are separated; pieces of one object are merged."""

import dataclasses

import numpy as np
import pytest

from recon.recognition import cuts, separation
from recon.recognition.recognition import components, recognise
from recon.recognition.synthetic import Orbit, observe, random_composite, voxelise
from recon.records import PointCloud
from recon.settings import RecognitionSettings

SETTINGS = RecognitionSettings()
COLOURS = np.full((2, 3), 120.0)


def seen(composite, rng):
    return observe(composite, COLOURS, Orbit(), rng)


def merged_clouds(*clouds):
    points = np.concatenate([cloud.points for cloud in clouds])
    return PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8))


@pytest.mark.parametrize("kind", ["apple tree", "pine tree", "cottage"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_two_objects_that_nearly_touch_are_separated(kind, seed):
    rng = np.random.default_rng(seed)
    first = random_composite(kind, rng)
    second = dataclasses.replace(
        first, axis=np.add(first.axis, [2.0 * first.widest.max() + 0.3, 0.0])
    )
    voxels = voxelise(merged_clouds(seen(first, rng), seen(second, rng)))
    instance = components(voxels, SETTINGS)
    assert np.bincount(instance[instance >= 0]).max() > 0.9 * (instance >= 0).sum()
    found = [one for one in recognise(voxels, SETTINGS).objects if one.num_voxels > 60]
    assert [one.label for one in found] == [kind, kind]
    assert found[0].centre[::2] == pytest.approx(first.axis, abs=0.3)
    assert found[1].centre[::2] == pytest.approx(second.axis, abs=0.3)


@pytest.mark.parametrize("kind", ["apple tree", "pine tree", "cottage"])
def test_single_object_is_not_split(kind):
    for seed in range(4):
        rng = np.random.default_rng(seed)
        voxels = voxelise(seen(random_composite(kind, rng), rng))
        assert len([one for one in recognise(voxels, SETTINGS).objects if one.num_voxels > 60]) == 1


def test_two_halves_of_a_crown_are_merged():
    rng = np.random.default_rng(3)
    tree = random_composite("pine tree", rng)
    cloud = seen(tree, rng)
    # A strip through the middle of the crown was not seen.
    beside = np.abs(cloud.points[:, 0] - tree.axis[0]) > 2.5
    strip = beside | (cloud.points[:, 1] < tree.heights[1])
    voxels = voxelise(cloud.select(strip))
    sizes = np.bincount(components(voxels, SETTINGS)[components(voxels, SETTINGS) >= 0])
    assert (sizes >= SETTINGS.min_voxels).sum() >= 2
    found = recognise(voxels, SETTINGS).objects
    assert [one.label for one in found] == ["pine tree"]
    assert found[0].centre[::2] == pytest.approx(tree.axis, abs=0.3)


@pytest.mark.parametrize("seed", [2, 3, 5])
def test_cottage_seen_from_two_sides_is_merged(seed):
    rng = np.random.default_rng(seed)
    cottage = random_composite("cottage", rng)
    cloud = seen(cottage, rng)
    turn = np.arctan2(*(cloud.points[:, ::2] - cottage.axis).T) % (2.0 * np.pi)
    # Half of the wall with the lower end of its roof, and a strip opposite.
    eaves, tip = cottage.heights[1:]
    half = (turn > 2.0) & (turn < 4.6) & (cloud.points[:, 1] < 0.7 * eaves + 0.3 * tip)
    strip = (turn < 0.7) & (cloud.points[:, 1] < eaves + 1.0)
    voxels = voxelise(cloud.select(half | strip))
    assert components(voxels, SETTINGS).max() == 1
    found = recognise(voxels, SETTINGS).objects
    assert [one.label for one in found] == ["cottage"]
    assert found[0].centre[::2] == pytest.approx(cottage.axis, abs=0.5)


def test_facing_walls_are_not_merged():
    rng = np.random.default_rng(0)
    walls = [rng.uniform([x, 1.0, -4.0], [x, 8.0, 4.0], (3000, 3)) for x in (0.0, 7.0)]
    points = np.concatenate(walls) + rng.normal(0.0, 0.1, (6000, 3))
    voxels = voxelise(PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8)))
    assert [one.label for one in recognise(voxels, SETTINGS).objects] == ["unknown", "unknown"]


def test_fence_is_not_split(monkeypatch):
    rng = np.random.default_rng(1)
    pales = [
        np.array([x, 0.0, 0.0])
        + rng.uniform([-0.4, 1.0, -0.4], [0.4, 6.0, 0.4], (60, 3))
        + rng.normal(0.0, 0.25, (60, 3))
        for x in np.arange(-10.0, 11.0, 2.5)
    ]
    points = np.concatenate(pales)
    points = points[points[:, 1] > 0.0]
    voxels = voxelise(PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8)))
    assert [one.label for one in recognise(voxels, SETTINGS).objects] == ["unknown"]
    monkeypatch.setattr(separation, "SHEET", 0.0)
    monkeypatch.setattr(separation, "CLOSELY_EXPLAINED", np.inf)
    assert len(recognise(voxels, SETTINGS).objects) == 2


def test_no_second_object_is_looked_for_in_a_long_corner_of_walls(monkeypatch):
    rng = np.random.default_rng(0)
    walls = [rng.uniform(0.0, size, (9000, 3)) for size in ((30.0, 12.0, 0.0), (0.0, 12.0, 9.0))]
    points = np.concatenate(walls) + rng.normal([0.0, 1.0, 0.0], 0.15, (18000, 3))
    voxels = voxelise(PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8)))
    tried: list[int] = []
    monkeypatch.setattr(
        separation, "narrow_cuts", lambda cells, *_, **__: tried.append(len(cells)) or []
    )
    assert len(recognise(voxels, SETTINGS).objects) == 1
    assert not tried
    monkeypatch.setattr(separation, "CLOSELY_EXPLAINED", np.inf)
    recognise(voxels, SETTINGS)
    assert tried


@pytest.mark.parametrize("seed", [2, 8])
def test_crown_touching_a_cottage_is_joined_with_its_separate_trunk(seed):
    rng = np.random.default_rng(seed)
    cottage, tree = (random_composite(kind, rng) for kind in ("cottage", "pine tree"))
    away = cottage.widest.max() + tree.widest.max()
    tree = dataclasses.replace(tree, axis=np.add(cottage.axis, [away, 0.0]))
    cloud = seen(tree, rng)
    # The upper part of the trunk was not seen.
    height = cloud.points[:, 1]
    gap = (height > tree.heights[1] - 2.5) & (height < tree.heights[1] + 0.4)
    voxels = voxelise(merged_clouds(seen(cottage, rng), cloud.select(~gap)))
    sizes = np.bincount(components(voxels, SETTINGS)[components(voxels, SETTINGS) >= 0])
    assert (sizes >= SETTINGS.min_voxels).sum() == 2
    found = recognise(voxels, SETTINGS).objects
    assert [one.label for one in found] == ["cottage", "pine tree"]
    assert found[1].centre[::2] == pytest.approx(tree.axis, abs=0.3)


def test_cells_beyond_the_other_object_do_not_belong_to_a_solid():
    index = np.array([[x, y, 0] for x in range(12) for y in range(4)])
    cells = voxelise(merged_clouds(*[PointCloud(points=np.repeat(index + 0.5, 5, axis=0))]))
    second = cells.means[:, 0] > 6.0
    reaching = second ^ (
        cells.means[:, 0] > 10.0
    )  # belongs to the first solid again, at the far end
    assert np.array_equal(cuts._gathered(reaching, cells), second)
    assert np.array_equal(cuts._gathered(second, cells), second)
