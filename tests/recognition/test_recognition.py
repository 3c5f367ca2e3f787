"""Objects of a map get the right label, position and size."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.geometry import pose, rotation_about_y, transform
from recon.recognition.fitting.composite import Composite
from recon.recognition.recognition import components, recognise
from recon.recognition.synthetic import Orbit, observe, random_composite, voxelise
from recon.records import PointCloud, Voxels
from recon.settings import RecognitionSettings

SETTINGS = RecognitionSettings()
NEAR = Orbit()
COLOURS = np.array([[110.0, 70.0, 30.0], [40.0, 150.0, 40.0]])


def orbit_of(kind: str, seed: int, orbit: Orbit = NEAR):
    rng = np.random.default_rng(seed)
    composite = random_composite(kind, rng)
    return composite, voxelise(observe(composite, COLOURS, orbit, rng))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["apple tree", "pine tree", "cottage"])
def test_object_gets_its_label_position_and_size(kind, seed):
    composite, voxels = orbit_of(kind, seed)
    found = max(recognise(voxels, SETTINGS).objects, key=lambda one: one.num_voxels)
    assert found.label == kind
    assert found.centre[::2] == pytest.approx(composite.axis, abs=0.1)
    assert found.size[1] == pytest.approx(composite.heights[-1], rel=0.1)
    assert found.parts[0].solid.radius == pytest.approx(composite.radii[0][0], rel=0.05)


def test_empty_map_has_no_objects():
    _, voxels = orbit_of("cottage", 0)
    nothing = voxels.select(slice(0, 0))
    found = recognise(nothing, SETTINGS)
    assert found.objects == ()
    assert components(nothing, SETTINGS).shape == (0,)


def test_ground_belongs_to_no_object():
    _, voxels = orbit_of("cottage", 0)
    label = recognise(voxels, SETTINGS).label
    low = voxels.centres[:, 1] < SETTINGS.clearance(1.0)
    assert low.any()
    assert (label[low] == -1).all()
    assert (label[~low] >= 0).any()


def test_order_of_cells_does_not_matter():
    _, voxels = orbit_of("pine tree", 1)
    order = np.random.default_rng(0).permutation(len(voxels))
    shuffled: Voxels = voxels.select(order)
    straight, mixed = recognise(voxels, SETTINGS), recognise(shuffled, SETTINGS)
    assert [one.label for one in straight.objects] == [one.label for one in mixed.objects]
    assert (straight.label[order] == mixed.label).all()


@settings(max_examples=9)
@given(
    kind=st.sampled_from(["apple tree", "pine tree", "cottage"]),
    angle=st.floats(0.0, 6.28),
    shift=st.tuples(st.floats(-99.0, 99.0), st.floats(-99.0, 99.0)),
)
def test_rotating_and_moving_a_world_does_not_change_labels(kind, angle, shift):
    rng = np.random.default_rng(11)
    composite = random_composite(kind, rng)
    cloud = observe(composite, COLOURS, NEAR, rng)
    T = pose(rotation_about_y(angle), [shift[0], 0.0, shift[1]])
    found = recognise(voxelise(cloud.transformed(T)), SETTINGS)
    assert [one.label for one in found.objects if one.num_voxels > 40] == [kind]
    axis = transform(T, np.array([[composite.axis[0], 0.0, composite.axis[1]]]))[0]
    assert found.objects[0].centre[::2] == pytest.approx(axis[::2], abs=0.2)


@pytest.mark.parametrize("cell_size", [0.5, 2.0])
def test_cell_size_does_not_matter(cell_size):
    rng = np.random.default_rng(2)
    composite = random_composite("cottage", rng)
    voxels = voxelise(observe(composite, COLOURS, NEAR, rng), cell_size, 4)
    found = max(recognise(voxels, SETTINGS).objects, key=lambda one: one.num_voxels)
    assert found.label == "cottage"


@pytest.mark.parametrize("colour", [(0, 0, 0), (128, 128, 128), (40, 150, 40)])
def test_uniformly_coloured_object_is_named_by_shape(colour):
    _, voxels = orbit_of("pine tree", 1)
    plain = dataclasses.replace(voxels, colours=np.tile(np.uint8(colour), (len(voxels), 1)))
    assert [one.label for one in recognise(plain, SETTINGS).objects] == ["pine tree"]


def test_single_cell_is_counted_but_not_an_object():
    _, voxels = orbit_of("cottage", 0)
    one = voxels.select(voxels.centres[:, 1] > 5).select(slice(0, 1))
    found = recognise(one, SETTINGS)
    assert found.objects == ()
    assert found.failures == {"fewer than 12 cells": 1}


def test_speck_above_the_ground_is_not_an_object():
    rng = np.random.default_rng(0)
    points = rng.uniform([40, 5, 40], [46, 6, 43], (300, 3))
    cloud = PointCloud(points=points, colours=np.zeros((300, 3), np.uint8))
    found = recognise(voxelise(cloud), SETTINGS)
    assert found.objects == ()
    assert found.failures == {"hovers over the ground, held by nothing known": 1}


def test_wall_is_unknown():
    rng = np.random.default_rng(0)
    points = rng.uniform([0, 0, 0], [20, 8, 0.2], (9000, 3))
    cloud = PointCloud(points=points, colours=np.zeros((9000, 3), np.uint8))
    found = recognise(voxelise(cloud), SETTINGS).objects
    assert [one.label for one in found] == ["unknown"]
    assert found[0].size == pytest.approx([20, 8, 0.2], abs=1.2)


def test_probabilities_are_calibrated():
    chances, rights = [], []
    for seed in range(30):
        rng = np.random.default_rng(1000 + seed)
        kind = ["apple tree", "pine tree", "cottage"][seed % 3]
        orbit = Orbit(sigma_px=0.2, num_views=3, arc_rad=2.0)
        voxels = voxelise(observe(random_composite(kind, rng), COLOURS, orbit, rng))
        for one in recognise(voxels, SETTINGS).objects:
            if one.label != "unknown" and one.num_voxels > 40:
                chances.append(one.probability)
                rights.append(one.label == kind)
    assert len(rights) > 20
    assert np.mean(rights) == pytest.approx(np.mean(chances), abs=0.12)


@pytest.mark.parametrize("top", [13.0, 14.0])
def test_lower_half_of_a_crown_is_not_the_cone_of_a_pine(top):
    tree = Composite(
        shapes=("cylinder", "sphere"),
        axis=np.array([3.0, 4.0]),
        heights=np.array([0.0, 9.5, 19.5]),
        radii=(np.array([1.7]), np.array([])),
    )
    seen = observe(tree, COLOURS, NEAR, np.random.default_rng(0))
    voxels = voxelise(seen.select(seen.points[:, 1] < top))
    found = recognise(voxels, SETTINGS).objects
    assert [one.label for one in found] in (["unknown"], ["apple tree"])
