"""Catalogue kinds made of boxes, balls and posts on and beside each other."""

import numpy as np
import pytest

from recon.recognition.naming.catalogue import read_catalogue
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.naming import Naming, name_object
from recon.recognition.recognition import recognise
from recon.recognition.segments.solid_pieces import solid_pieces
from recon.recognition.synthetic import Orbit, observe, voxelise
from recon.records import UNKNOWN, Box, Cylinder, Solid, Sphere, Voxels
from recon.settings import RecognitionSettings

OWN = """
[[object]]
name = "robot"
parts = [{ role = "body", shapes = ["box"] }, { role = "head", shapes = ["sphere"] }]

[[object]]
name = "pair"
parts = [{ role = "left", shapes = ["sphere"] },
         { role = "right", shapes = ["sphere"], place = "beside" }]

[[object]]
name = "hydrant"
parts = [{ role = "post", shapes = ["cylinder"] },
         { role = "valve", shapes = ["sphere"], place = "beside", count = [1, 2] }]
"""
UP = np.array([0.0, 1.0, 0.0])


def box(height: float, width: float) -> Box:
    """Make a box on the ground."""
    sizes = np.array([width, height, width])
    return Box(centre=np.array([0.0, height / 2.0, 0.0]), axes=np.eye(3), sizes=sizes)


def ball(radius: float, *centre: float) -> Sphere:
    return Sphere(centre=np.array(centre), radius=radius)


def post(radius: float, height: float) -> Cylinder:
    return Cylinder(point=np.zeros(3), axis=UP, radius=radius, height=height)


ROBOT = [box(6.5, 6.5), ball(2.6, 0.0, 8.6, 0.0)]
PAIR = [ball(3.5, 0.0, 3.5, 0.0), ball(2.8, 6.2, 2.8, 0.0)]
HYDRANT = [post(2.2, 9.0), ball(1.9, 3.6, 5.0, 0.0)]
TREE = [post(1.5, 7.0), ball(4.0, 0.0, 10.0, 0.0)]


def cells_of(solids: list[Solid], seed: int = 1) -> Voxels:
    rng = np.random.default_rng(seed)
    colours = rng.uniform(40.0, 200.0, (len(solids), 3))
    cells = voxelise(observe(solids, colours, Orbit(points_per_pixel=0.3), rng), 0.7, 3)
    return cells.select(cells.centres[:, 1] > 0.7)


@pytest.fixture(scope="module")
def kinds(tmp_path_factory) -> dict[str, Kind]:
    path = tmp_path_factory.mktemp("catalogue") / "own.toml"
    path.write_text(OWN)
    return {kind.name: kind for kind in read_catalogue(path)}


def named(solids: list[Solid], *kinds: Kind) -> Naming:
    return name_object(cells_of(solids), 0.0, kinds)


@pytest.mark.parametrize(
    ("name", "solids"), [("robot", ROBOT), ("pair", PAIR), ("hydrant", HYDRANT)]
)
def test_object_of_solids_gets_the_label_and_parts_of_its_kind(kinds, name, solids):
    found = named(solids, *kinds.values())
    assert found.label == name
    assert found.probability > 0.5
    rules = {part.role: part.shapes for part in kinds[name].parts}
    assert {part.role for part in found.parts} == set(rules)
    assert all(part.solid.kind in rules[part.role] for part in found.parts)


def test_head_of_a_robot_has_the_right_size(kinds):
    parts = {part.role: part.solid for part in named(ROBOT, kinds["robot"]).parts}
    assert parts["head"].radius == pytest.approx(2.6, rel=0.1)
    # The lowest cells of the body belong to the ground.
    assert np.sort(parts["body"].sizes) == pytest.approx([5.5, 6.5, 6.5], rel=0.1)


@pytest.mark.parametrize("solids", [[box(7.0, 6.0)], [ball(4.0, 0.0, 4.0, 0.0)], HYDRANT])
def test_single_solid_is_not_a_pair_and_a_post_is_not_a_ball(kinds, solids):
    assert named(solids, kinds["pair"]).label == UNKNOWN


def test_crown_on_a_trunk_is_not_beside_it(kinds):
    assert named(TREE, kinds["hydrant"]).label == UNKNOWN


def test_slenderness_of_a_part_is_checked(kinds):
    post, valve = kinds["hydrant"].parts
    for bounds, label in (((3.0, 6.0), "hydrant"), ((6.0, 9.0), UNKNOWN)):
        kind = Kind(name="hydrant", parts=(with_slenderness(post, bounds), valve))
        assert named(HYDRANT, kind).label == label


def with_slenderness(part, bounds):
    return type(part)(role=part.role, shapes=part.shapes, slenderness=bounds)


def test_indistinguishable_solids_are_not_pieces():
    cells = cells_of([ball(4.0, 0.0, 4.0, 0.0)])
    assert solid_pieces(cells.select(np.arange(6)), {"sphere"}, 2).pieces == ()


def test_robot_in_a_map_is_recognised_from_a_catalogue_file(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(OWN)
    settings = RecognitionSettings(catalogue=(str(path),))
    (found,) = recognise(cells_of(ROBOT), settings).objects
    assert found.label == "robot"
