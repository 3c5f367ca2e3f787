"""Strange shapes that resemble a kind of the village are not given its name."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from recon.recognition import separation
from recon.recognition.naming import assembly, probability
from recon.recognition.naming.catalogue import read_catalogues
from recon.recognition.naming.naming import name_object
from recon.recognition.naming.probability import Logistic
from recon.recognition.recognition import recognise
from recon.recognition.synthetic import voxelise
from recon.records import PointCloud
from recon.settings import RecognitionSettings

KINDS = read_catalogues(["village"])
OF_ANY_FORM = tuple(
    replace(
        kind,
        elongation=None,
        parts=tuple(replace(part, slenderness=None) for part in kind.parts),
    )
    for kind in KINDS
)
"""The kinds without limits of their elongation and of their parts' slenderness."""
ALWAYS = Logistic(middle=-1e9, steepness=1.0)
URN = [(4.0, 0.0), (2.0, 2.0), (2.0, 4.0), (7.5, 11.0), (5.0, 16.0), (7.0, 18.0)]
HOURGLASS = [(8.0, 0.0), (8.0, 5.0), (1.5, 13.0), (8.0, 21.0), (8.0, 26.0)]


def turned(frustum, outline, rng):
    """Sample the surface of revolution of an outline of radii and heights."""
    pieces = []
    for (bottom, low), (top, high) in pairwise(outline):
        points = frustum(rng, bottom, top, high - low, int(200 * (high - low)))
        pieces.append(points[:, [0, 2, 1]] + [0.0, low, 0.0])
    return np.concatenate(pieces)


def cells_of(points, rng, noise=0.25):
    """The cells above the ground of points with noise."""
    points = points + rng.normal(0.0, noise, points.shape)
    voxels = voxelise(PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8)))
    return voxels.select(voxels.centres[:, 1] >= 1.0)


@pytest.mark.parametrize("scale", [1.0, 1.2])
def test_bulging_urn_is_no_apple_tree(scale, surfaces, monkeypatch):
    rng = np.random.default_rng(0)
    voxels = cells_of(scale * turned(surfaces.frustum, URN, rng), rng)
    assert name_object(voxels, 0.0, KINDS).label == "unknown"
    monkeypatch.setattr(probability, "STRAIGHT", ALWAYS)
    assert name_object(voxels, 0.0, KINDS).label == "apple tree"


def test_front_of_a_ball_on_the_ground_has_no_trunk(surfaces, monkeypatch):
    rng = np.random.default_rng(0)
    points = np.array([0.0, 11.8, 0.0]) + surfaces.ball(rng, [8.0, 11.0, 8.0], 6000)
    voxels = cells_of(points[points[:, 2] > 2.0], rng)
    chances = dict(name_object(voxels, 0.0, OF_ANY_FORM).nearest)
    monkeypatch.setattr(probability, "LOWEST", ALWAYS)
    rivals = dict(name_object(voxels, 0.0, OF_ANY_FORM).nearest)
    assert chances.get("apple tree", 0.0) < 0.05 * rivals["apple tree"]


def test_lower_half_of_an_hourglass_is_no_cottage(surfaces, monkeypatch):
    rng = np.random.default_rng(0)
    points = turned(surfaces.frustum, HOURGLASS, rng)
    voxels = cells_of(points[points[:, 2] > 0.0], rng)
    assert "cottage" not in [one.label for one in recognise(voxels, RecognitionSettings()).objects]
    monkeypatch.setattr(separation, "TIPS", ())
    assert "cottage" in [one.label for one in recognise(voxels, RecognitionSettings()).objects]


def stool(surfaces, rng):
    """A round seat on three legs, as high as wide."""
    legs = [
        surfaces.frustum(rng, 0.6, 0.6, 8.0, 400)[:, [0, 2, 1]]
        + [3.5 * np.cos(turn), 0.0, 3.5 * np.sin(turn)]
        for turn in np.radians([90.0, 210.0, 330.0])
    ]
    seat = rng.uniform(-5.0, 5.0, (4000, 3)) * [1.0, 0.05, 1.0] + [0.0, 8.2, 0.0]
    return np.concatenate([*legs, seat[np.hypot(*seat[:, ::2].T) < 5.0]])


def front_of_a_bench(surfaces, rng):
    """The side of a bench that one level view shows."""
    back = rng.uniform([-12.0, 6.0, 0.0], [12.0, 12.0, 0.0], (2500, 3))
    seat = rng.uniform([-12.0, 5.0, 0.0], [12.0, 5.6, 2.0], (2500, 3))
    legs = [np.array([x, 2.5, 1.5]) + surfaces.box(rng, [1.0, 5.0, 1.0], 400) for x in (-9.0, 9.0)]
    return np.concatenate([back, seat, *legs])


@pytest.mark.parametrize(("make", "name"), [(stool, "table"), (front_of_a_bench, "bench")])
def test_proportions_tell_a_stool_from_a_table_and_a_front_from_a_bench(make, name, surfaces):
    rng = np.random.default_rng(0)
    voxels = cells_of(make(surfaces, rng), rng, noise=0.1)
    assert name_object(voxels, 0.0, KINDS).label == "unknown"
    any_proportion = tuple(replace(kind, slenderness=None, elongation=None) for kind in KINDS)
    assert name_object(voxels, 0.0, any_proportion).label == name


def corner_of_a_room(surfaces, rng):
    """A patch of a floor before a wall, and what hangs on the wall."""
    floor = rng.uniform([-12.0, 1.5, 0.0], [12.0, 1.7, 10.0], (4000, 3))
    wall = rng.uniform([-12.0, 1.5, -0.1], [12.0, 11.0, 0.1], (4000, 3))
    hung = [np.array([x, 4.0, 2.0]) + surfaces.box(rng, [2.0, 1.0, 1.0], 200) for x in (-6.0, 6.0)]
    return np.concatenate([floor, wall, *hung])


def test_a_floor_that_carries_what_hangs_above_it_is_no_seat(surfaces, monkeypatch):
    rng = np.random.default_rng(0)
    voxels = cells_of(corner_of_a_room(surfaces, rng), rng, noise=0.1)
    assert "bench" not in dict(name_object(voxels, 0.0, KINDS).nearest)
    monkeypatch.setattr(assembly, "_num_in_place", lambda _, found, *__: len(found))
    assert "bench" not in dict(name_object(voxels, 0.0, KINDS).nearest)
    monkeypatch.setattr(assembly, "_is_level", lambda *_: True)
    assert name_object(voxels, 0.0, KINDS).label == "bench"


def pyramid(surfaces, rng):
    """A cone on a low foot, as coarse cells show a pyramid."""
    return turned(surfaces.frustum, [(7.0, 0.0), (7.0, 2.0), (0.3, 9.0)], rng)


def test_a_foot_is_no_wall_of_a_cottage(surfaces):
    rng = np.random.default_rng(0)
    voxels = cells_of(pyramid(surfaces, rng), rng)
    assert "cottage" not in dict(name_object(voxels, 0.0, KINDS).nearest)
    assert dict(name_object(voxels, 0.0, OF_ANY_FORM).nearest)["cottage"] > 0.3


def test_in_metres_a_cottage_of_a_hand_is_none(surfaces):
    rng = np.random.default_rng(0)
    outline = [(5.0, 0.0), (5.0, 7.0), (5.5, 7.0), (1.0, 11.0)]
    voxels = cells_of(turned(surfaces.frustum, outline, rng), rng)
    small = voxelise(PointCloud(points=0.02 * voxels.means, colours=voxels.colours), 0.02, 1)
    for cells, is_metric, label in (
        (voxels, True, "cottage"),
        (small, False, "cottage"),
        (small, True, "unknown"),
    ):
        assert name_object(cells, 0.0, KINDS, is_metric).label == label
