"""Clearance of a body: from its axis to surfaces at, above and below its height."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.errors import InputError
from recon.world.body import split_at
from recon.world.generator import plain_ground
from recon.world.visuals import MeshVisual, PolygonVisual, Scene, SphereVisual, Vertex
from recon.world.world import World

from .test_world import upright

HEIGHT = 5.5


def wall(x0, x1, low, high, z=0.0):
    corners = ((x0, low, z), (x1, low, z), (x1, high, z), (x0, high, z))
    return PolygonVisual(
        cull_back=False,
        vertices=tuple(Vertex(position=c, colour=(1, 1, 1, 1), uv=(0, 0)) for c in corners),
    )


def clearance(world, *places):
    return world.body_clearance(np.array(places, dtype=np.float64), HEIGHT)


def test_distance_to_a_wall_does_not_depend_on_its_height(world_of):
    low, high = world_of(wall(-5, 5, 0.0, 1.0)), world_of(wall(-5, 5, 4.0, 9.0))
    for world in (low, high):
        assert clearance(world, (0, 3), (0, -3), (9, 0)) == pytest.approx([3, 3, 4], abs=4e-3)


def test_overhang_is_measured_from_the_top_of_the_body(world_of):
    world = world_of(wall(-5, 5, 7.5, 9.0))
    assert clearance(world, (0, 0), (0, 1.5)) == pytest.approx([2.0, 2.5], abs=4e-3)


def test_wide_crown_above_the_body_leaves_clearance_below(world_of):
    world = world_of(upright(1, 8), SphereVisual(centre=(0, 12, 0), radius=4))
    assert clearance(world, (3.0, 0.0))[0] == pytest.approx(2.0, abs=0.01)
    side = np.hypot(6.0, 6.5) - 4.0
    assert clearance(world, (6.0, 0.0))[0] == pytest.approx(side, abs=0.01)


def test_ground_is_ignored_and_an_empty_world_is_infinitely_far(world_of):
    assert np.isinf(clearance(world_of(plain_ground()), (0, 0))).all()
    assert clearance(world_of(plain_ground(), wall(-5, 5, 0, 3, z=-4)), (0, 0)) == pytest.approx(
        [4], abs=4e-3
    )


@settings(max_examples=60)
@given(st.lists(st.floats(-3, 3), min_size=9, max_size=9), st.floats(-2, 2))
def test_split_triangle_keeps_its_area_and_its_sides(values, height):
    corners = np.array(values).reshape(1, 3, 3)
    above, below = split_at(corners, height)
    assert (above[..., 1] >= height - 1e-9).all()
    assert (below[..., 1] <= height + 1e-9).all()
    assert area(above) + area(below) == pytest.approx(area(corners), abs=1e-6)


def area(corners):
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return 0.5 * np.linalg.norm(np.cross(a, b), axis=1).sum()


def test_enclosing_walls_and_meshes_have_an_inside(world_of, tmp_path):
    sides = [wall(-3, 3, 0, 6, z) for z in (-3.0, 3.0)]
    sides += [turned(wall(-3, 3, 0, 6, x)) for x in (-3.0, 3.0)]
    world = world_of(*sides)
    assert world.is_inside([[0, 1, 0], [5, 1, 0]]).tolist() == [True, False]
    (tmp_path / "box.obj").write_text(BOX)
    scene = Scene(visuals=(MeshVisual(file="box.obj"),), folder=tmp_path)
    box = World(scene, world.eyes, world.render, world.floor)
    assert box.is_inside([[0.5, 0.5, 0.5], [1.5, 0.5, 0.5]]).tolist() == [True, False]


def turned(visual):
    vertices = tuple(
        Vertex(position=v.position[::-1], colour=v.colour, uv=v.uv) for v in visual.vertices
    )
    return PolygonVisual(cull_back=False, vertices=vertices)


BOX = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1)) + "".join(
    f"f {a} {b} {c}\nf {a} {c} {d}\n"
    for a, b, c, d in (
        (1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4),
    )
)  # fmt: skip


def test_shape_of_positions_is_checked(world_of):
    with pytest.raises(InputError, match=r"places_xz has shape \(3,\), but \(N, 2\) is needed"):
        world_of().body_clearance([1.0, 2.0, 3.0], HEIGHT)
