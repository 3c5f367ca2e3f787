"""Composite kinds of planes and bars are named from an orbit of stereo pairs."""

from dataclasses import replace

import numpy as np
import pytest

from recon.recognition.fitting.composite import Composite
from recon.recognition.naming import arrangement, assembly, hypotheses
from recon.recognition.naming.acceptance import accepted
from recon.recognition.naming.catalogue import read_catalogues
from recon.recognition.naming.naming import name_object
from recon.recognition.naming.probability import Logistic
from recon.recognition.recognition import recognise
from recon.recognition.synthetic import Orbit, observe, voxelise
from recon.records import Box, Cylinder, PointCloud, Sphere
from recon.settings import RecognitionSettings, Settings, updated

SETTINGS = RecognitionSettings()
UP = np.array([0.0, 1.0, 0.0])
ORBIT = Orbit()


def box(centre, sizes, axes=None):
    axes = np.eye(3) if axes is None else axes
    return Box(centre=np.array(centre), axes=axes, sizes=np.array(sizes))


def leg(x, z, height):
    return Cylinder(point=np.array([x, 0.0, z]), axis=UP, radius=0.5, height=height)


def house(u):
    width, depth, height, rise = u(9, 13), u(7, 10), u(5, 8), u(3, 5)
    slope = np.hypot(depth / 2, rise)
    roof = []
    for side in (-1, 1):
        normal = np.array([0, depth / 2, side * rise]) / slope
        down = np.array([0, -rise * side, depth / 2]) / slope
        axes = np.stack([np.array([1.0, 0, 0]), normal, down])
        roof.append(box([0, height + rise / 2, side * depth / 4], [width, 0.2, slope], axes))
    return [box([0, height / 2, 0], [width, height, depth]), *roof]


def table(u):
    width, depth, height = u(8, 12), u(5, 8), u(3.2, 4.2)
    feet = [leg(i * (width / 2 - 1), j * (depth / 2 - 1), height) for i in (-1, 1) for j in (-1, 1)]
    return [box([0, height, 0], [width, 0.6, depth]), *feet]


def bench(u):
    width, depth, height, rise = u(7, 10), u(2.5, 3.5), u(2.2, 2.8), u(2.5, 3.5)
    sides = [box([i * (width / 2 - 0.8), height / 2, 0], [0.8, height, 2.4]) for i in (-1, 1)]
    back = box([0, height + rise / 2, -depth / 2], [width, rise, 0.5])
    return [box([0, height, 0], [width, 0.5, depth]), back, *sides]


def lamp_post(u):
    height, radius = u(9, 12), u(1.4, 2.0)
    post = Cylinder(point=np.zeros(3), axis=UP, radius=0.5, height=height)
    return [post, Sphere(centre=np.array([0, height + radius, 0]), radius=radius)]


def label_of(parts, rng, orbit=ORBIT, cell_size=1.0):
    cloud = observe(parts, rng.uniform(40, 200, (len(parts), 3)), orbit, rng)
    voxels = voxelise(cloud, cell_size)
    found = recognise(voxels, SETTINGS).objects
    return max(found, key=lambda one: one.num_voxels).label if found else "none"


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(
    ("make", "kind"),
    [(house, "house"), (table, "table"), (bench, "bench"), (lamp_post, "lamp post")],
)
def test_composite_kind_is_named(make, kind, seed):
    rng = np.random.default_rng(seed)
    assert label_of(make(rng.uniform), rng) == kind


@pytest.mark.parametrize(("num_points", "is_lamp"), [(8, True), (400, False)])
def test_few_points_in_a_row_do_not_make_a_lamp_post_as_long_as_a_bench(num_points, is_lamp):
    rng = np.random.default_rng(0)
    lamp = observe(lamp_post(rng.uniform), np.full((2, 3), 90.0), ORBIT, rng)
    row = np.repeat([[x, 5.0, 0.0] for x in (1.5, 2.5, 3.5, 4.5, 5.5)], num_points, axis=0)
    points = np.concatenate([lamp.points, row])
    voxels = voxelise(PointCloud(points=points, colours=np.full(points.shape, 90, np.uint8)))
    labels = [one.label for one in recognise(voxels, SETTINGS).objects]
    assert (labels == ["lamp post"]) == is_lamp


@pytest.mark.parametrize(("radius", "kind"), [(1.8, "lamp post"), (4.5, "apple tree")])
def test_lamp_is_small_for_its_height_unlike_a_crown(radius, kind):
    rng = np.random.default_rng(0)
    post = Cylinder(point=np.zeros(3), axis=UP, radius=0.8, height=9.4)
    crown = Sphere(centre=np.array([0, 9.4 + radius, 0]), radius=radius)
    assert label_of([post, crown], rng) == kind


@pytest.mark.parametrize(("make", "kind"), [(house, "house"), (table, "table")])
def test_composite_kind_of_thousands_of_cells_is_named(make, kind):
    rng = np.random.default_rng(0)
    dense = Orbit(points_per_pixel=4.0, sigma_px=0.02)
    assert label_of(make(rng.uniform), rng, dense, cell_size=0.3) == kind


def test_board_without_legs_and_box_are_not_tables():
    rng = np.random.default_rng(3)
    assert label_of([box([0, 3.5, 0], [9, 0.6, 6])], rng) != "table"
    assert label_of([box([0, 2.5, 0], [9, 5.0, 6])], rng) not in ("table", "house", "bench")


@pytest.mark.parametrize("seed", [0, 7])
def test_a_slice_of_a_noisy_wall_is_no_seat(seed, monkeypatch):
    def label():
        rng = np.random.default_rng(seed)
        height = rng.uniform(3, 6)
        wall = box([0, height / 2, 0], [rng.uniform(16, 24), height, 0.6])
        return label_of([wall], rng, Orbit(sigma_px=0.15))

    assert label() == "unknown"
    always = Logistic(middle=-99.0, steepness=1.0)
    monkeypatch.setattr(hypotheses, "proportion_chance", lambda *_: 1.0)
    monkeypatch.setattr(arrangement, "UNPIERCED", always)
    assert label() == "unknown"
    monkeypatch.setattr(assembly, "FREE", always)
    assert label() == "bench"


def bulged(points, walls, by):
    """Bend the walls of a house outwards in the middle; points are (N, 3)."""
    bent, halves = points.copy(), walls.sizes / 2.0
    for axis, across in ((0, 2), (2, 0)):
        outside = np.abs(points[:, axis]) > 0.8 * halves[axis]
        on_wall = outside & (points[:, 1] < walls.sizes[1])
        share = np.clip(1.0 - (points[:, across] / halves[across]) ** 2, 0.0, None)
        bent[:, axis] += on_wall * by * np.sign(points[:, axis]) * share
    return bent


@pytest.mark.parametrize(("by", "is_house"), [(0.0, True), (0.3, True), (1.5, False)])
@pytest.mark.parametrize("seed", range(3))
def test_object_with_curved_walls_is_not_a_house(by, is_house, seed):
    rng = np.random.default_rng(seed)
    parts = house(rng.uniform)
    cloud = observe(parts, rng.uniform(40, 200, (len(parts), 3)), ORBIT, rng)
    voxels = voxelise(replace(cloud, points=bulged(cloud.points, parts[0], by)))
    found = max(recognise(voxels, SETTINGS).objects, key=lambda one: one.num_voxels)
    assert (found.label == "house") == is_house


@pytest.mark.parametrize(("rise", "low", "high"), [(0.9, 0.0, 0.8), (3.0, 0.9, 1.0)])
def test_roof_thinner_than_two_cells_is_doubtful(rise, low, high):
    cottage = Composite(
        shapes=("cylinder", "truncated cone"),
        axis=np.zeros(2),
        heights=np.array([0.0, 7.0, 7.0 + rise]),
        radii=(np.array([4.0]), np.array([4.8, 1.2])),
    )
    rng = np.random.default_rng(0)
    cloud = observe(cottage, rng.uniform(40, 200, (2, 3)), Orbit(eye_height=9.0), rng)
    (found,) = recognise(voxelise(cloud), SETTINGS).objects
    assert low <= dict(found.nearest).get("cottage", 0.0) <= high


@pytest.mark.parametrize("name", ["village", "household"])
def test_accepted_values_of_an_entry_are_listed(name):
    for kind in read_catalogues([name]):
        lines = accepted(kind)
        assert len(lines) >= len(kind.parts)
        assert all(part.role in " ".join(lines) for part in kind.parts)


def test_floating_or_tall_object_is_not_a_bench():
    parts = bench(np.random.default_rng(0).uniform)
    assert label_of(parts, np.random.default_rng(0)) == "bench"
    cloud = observe(parts, np.full((len(parts), 3), 120.0), Orbit(), np.random.default_rng(0))
    standing, rise = voxelise(cloud), np.array([0, 12, 0])
    risen = replace(standing, means=standing.means + rise, index=standing.index + rise)
    ground = updated(Settings(), {"recognition": {"ground": 0.0}}).recognition
    assert "bench" in {one.label for one in recognise(standing, ground).objects}
    assert "bench" not in {one.label for one in recognise(risen, ground).objects}
    tall = [
        box([0, 2.5, 0], [3.0, 0.5, 3.0]),
        box([0, 7.5, -1.5], [3.0, 10.0, 0.5]),
        *[leg(x, z, 2.5) for x in (-1, 1) for z in (-1, 1)],
    ]
    assert label_of(tall, np.random.default_rng(0)) != "bench"


def test_table_of_few_cells_is_less_sure(monkeypatch):
    rng, side = np.random.default_rng(0), 1.0 / 0.7
    parts = table(rng.uniform)
    voxels = voxelise(observe(parts, np.full((len(parts), 3), 120.0), Orbit(), rng), side)
    standing = voxels.select(voxels.centres[:, 1] >= side)
    kinds = read_catalogues(["village"])
    assert dict(name_object(standing, 0.0, kinds).nearest)["table"] < 0.9
    monkeypatch.setattr(hypotheses, "MANY", Logistic(middle=-99.0, steepness=1.0))
    assert dict(name_object(standing, 0.0, kinds).nearest)["table"] > 0.97
