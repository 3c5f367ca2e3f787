"""Furniture in metres, fully and partly seen, and objects that resemble it."""

from dataclasses import replace

import numpy as np
import pytest

from recon.recognition.naming.catalogue import read_catalogue
from recon.recognition.naming.naming import name_object
from recon.recognition.recognition import recognise
from recon.recognition.synthetic import Orbit, observe, voxelise
from recon.records import Box, Cylinder, PointCloud
from recon.settings import RecognitionSettings

SETTINGS = RecognitionSettings(catalogue=("household",), unit="m", ground_clearance=0.05)
SCALE = 12.0
"""World units of the eyes that look, per metre."""
CELL = 0.06
UP = np.array([0.0, 1.0, 0.0])
GREY = np.full((1, 3), 120.0)


def board(centre, sizes):
    return Box(centre=SCALE * np.array(centre), axes=np.eye(3), sizes=SCALE * np.array(sizes))


def legs(width, depth, height, radius):
    return [
        Cylinder(
            point=SCALE * np.array([i * (width / 2 - 0.04), 0.0, j * (depth / 2 - 0.04)]),
            axis=UP,
            radius=SCALE * radius,
            height=SCALE * height,
        )
        for i in (-1, 1)
        for j in (-1, 1)
    ]


def chair(u):
    width, depth, height, rise = u(0.38, 0.5), u(0.38, 0.5), u(0.42, 0.48), u(0.35, 0.5)
    seat = board([0, height, 0], [width, 0.03, depth])
    back = board([0, height + rise / 2, -depth / 2], [width, rise, 0.03])
    return [seat, back, *legs(width, depth, height, u(0.018, 0.03))]


def table(u, scale=1.0):
    width, depth, height = scale * u(0.8, 1.6), scale * u(0.6, 0.9), scale * u(0.68, 0.78)
    top = board([0, height, 0], [width, 0.04, depth])
    return [top, *legs(width, depth, height, u(0.025, 0.045))]


def carton(u):
    sizes = [u(0.25, 0.6), u(0.15, 0.6), u(0.2, 0.5)]
    return [board([0, sizes[1] / 2, 0], sizes)]


def stool(u):
    width, height = u(0.3, 0.38), u(0.44, 0.5)
    return [board([0, height, 0], [width, 0.03, width]), *legs(width, width, height, 0.02)]


def high_table(u):
    return table(u, 3.0)


def cells_of(parts, seed, arc_rad=2 * np.pi, colours=None):
    rng = np.random.default_rng([3, seed])
    orbit = Orbit(
        num_views=4 if arc_rad < 6 else 9,
        arc_rad=arc_rad,
        start_rad=rng.uniform(0.0, 2 * np.pi),
        eye_height=14.0,
        points_per_pixel=0.25,
    )
    shades = np.repeat(GREY, len(parts), axis=0) if colours is None else colours
    cloud = observe(parts, shades, orbit, rng)
    metric = PointCloud(points=cloud.points / SCALE, colours=cloud.colours)
    return voxelise(metric, CELL, min_count=4)


def label_of(make, seed, arc_rad=2 * np.pi, settings=SETTINGS):
    parts = make(np.random.default_rng(seed).uniform)
    found = recognise(cells_of(parts, seed, arc_rad), settings).objects
    return max(found, key=lambda one: one.num_voxels).label


@pytest.mark.parametrize(("make", "kind"), [(chair, "chair"), (table, "table"), (carton, "box")])
@pytest.mark.parametrize("arc_rad", [2 * np.pi, 2.5])
def test_furniture_is_named_even_if_partly_seen(make, kind, arc_rad):
    assert label_of(make, 1, arc_rad) == label_of(make, 2, arc_rad) == kind


@pytest.mark.parametrize("make", [stool, high_table])
@pytest.mark.parametrize("arc_rad", [2 * np.pi, 2.5])
def test_objects_similar_to_furniture_are_not_named(make, arc_rad):
    assert label_of(make, 1, arc_rad) == label_of(make, 2, arc_rad) == "unknown"


CATALOGUE = """
[[object]]
name = "desk"
parts = [
    {{ role = "top", shapes = ["plane"], tilt_deg = [0.0, 12.0], share = [0.3, 0.95]{top} }},
    {{ role = "leg", shapes = ["cylinder"], place = "under", count = [2, 6]{leg} }},
]
"""


def probability_of(tmp_path, cells, **rules):
    path = tmp_path / "kinds.toml"
    path.write_text(CATALOGUE.format(**{"top": "", "leg": ""} | rules))
    standing = cells.select(cells.centres[:, 1] > 0.05)
    nearest = dict(name_object(standing, 0.0, read_catalogue(path), is_metric=True).nearest)
    return nearest.get("desk", 0.0)


def test_sizes_of_the_parts_of_an_assembly_matter(tmp_path):
    cells = cells_of(table(np.random.default_rng(1).uniform), 1)
    assert probability_of(tmp_path, cells) > 0.9
    assert probability_of(tmp_path, cells, top=", size = { width = [0.7, 1.8] }") > 0.9
    assert probability_of(tmp_path, cells, top=", size = { width = [0.1, 0.5] }") < 0.1
    assert probability_of(tmp_path, cells, leg=", size = { radius = [0.2, 0.4] }") < 0.1


def test_hue_of_a_part_has_a_small_effect(tmp_path):
    parts = table(np.random.default_rng(1).uniform)
    red = np.array([[200.0, 40.0, 40.0], *[[120.0, 120.0, 120.0]] * 4])
    cells = cells_of(parts, 1, colours=red)
    fitting = probability_of(tmp_path, cells, top=", hue_deg = [340, 20]")
    other = probability_of(tmp_path, cells, top=", hue_deg = [180, 260]")
    assert fitting > 0.9
    assert 0.02 < other < 0.2
    grey = replace(cells, colours=np.full_like(cells.colours, 120))
    assert other < probability_of(tmp_path, grey, top=", hue_deg = [340, 20]") < fitting
