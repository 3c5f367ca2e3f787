"""Kinds learned from examples, saved as TOML, and rejected if indistinguishable."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.recognition.clouds import gathered
from recon.recognition.fitting.surface_points import surface
from recon.recognition.naming.descriptors import describe
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.learning import learn
from recon.recognition.naming.naming import name_object
from recon.records import Box, Cylinder, PointCloud, Sphere

UP = np.array([0.0, 1.0, 0.0])


def carton(rng):
    sizes = np.array([0.1, 0.24, 0.07]) * rng.uniform(0.9, 1.1, 3)
    return [Box(centre=np.array([0.0, sizes[1] / 2, 0.0]), axes=np.eye(3), sizes=sizes)]


def mug(rng):
    radius, height = 0.04 * rng.uniform(0.9, 1.1), 0.1 * rng.uniform(0.9, 1.1)
    return [Cylinder(point=np.zeros(3), axis=UP, radius=radius, height=height)]


def ball(rng):
    radius = 0.1 * rng.uniform(0.9, 1.1)
    return [Sphere(centre=np.array([0.0, radius, 0.0]), radius=radius)]


def example(make, seed):
    """Take the side of an object that faces the camera."""
    rng = np.random.default_rng(seed)
    whole = surface(make(rng), 4000, rng)
    turn = rng.uniform(0.0, 2.0 * np.pi)
    eye = np.array([np.cos(turn), 0.6, np.sin(turn)])
    seen = np.einsum("ij,ij->i", whole.normals, eye - whole.points) > 0
    points = whole.points[seen] + 0.001 * rng.normal(size=(int(seen.sum()), 3))
    return gathered(PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8)))


@pytest.fixture(scope="module")
def mugs():
    return [example(mug, seed) for seed in range(8)]


def test_learned_kind_accepts_its_own_and_rejects_others(mugs):
    lesson = learn("mug", mugs, {}, "m")
    kind = lesson.learned
    own = [kind.distance(describe(example(mug, 50 + seed))) for seed in range(5)]
    others = [kind.distance(describe(example(make, 70))) for make in (carton, ball)]
    assert np.mean(np.array(own) <= kind.threshold) >= 0.6
    assert min(others) > kind.threshold
    assert {group.name for group in lesson.groups} == {"size", "profile", "surface", "solids"}


def test_single_example_gives_low_confidence(mugs):
    chances = []
    for count in (1, 3, 8):
        kinds = (Kind(name="mug", learned=learn("mug", mugs[:count], {}).learned),)
        found = name_object(mugs[0], 0.0, kinds)
        assert found.label == "mug"
        chances.append(found.probability)
    assert chances == sorted(chances)
    assert 0.5 < chances[0] < 0.7
    assert chances[2] > 0.85


def test_indistinguishable_kind_is_rejected(mugs):
    first = learn("mug", mugs[:3], {})
    with pytest.raises(InputError, match="cup cannot be distinguished from mug"):
        learn("cup", mugs[3:], {"mug": first.learned})


def test_uninformative_feature_groups_are_left_out_with_a_reason(mugs):
    cartons = learn("carton", [example(carton, seed) for seed in range(3)], {})
    lesson = learn("mug", mugs, {"carton": cartons.learned})
    assert any(group.used for group in lesson.groups)
    assert all("times as far away" in group.reason for group in lesson.groups)
    used = {group.name for group in lesson.groups if group.used}
    assert set(lesson.learned.groups) == used


def test_learning_without_examples_is_rejected():
    with pytest.raises(InputError, match="at least one is needed"):
        learn("mug", [], {})
