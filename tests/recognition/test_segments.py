"""Segments: planes, components by density, convex pieces, the focus of all views."""

import numpy as np
import pytest

from recon.geometry import look_at, pose, transform
from recon.recognition.cells import gather
from recon.recognition.clouds import recognise_cloud
from recon.recognition.connectivity import linked, overhanging
from recon.recognition.fitting.surface_points import surface
from recon.recognition.recognition import recognise
from recon.recognition.segments.convexity import convex_pieces, fewest_pieces, relief_of
from recon.recognition.segments.focus import find_focus
from recon.recognition.segments.ground import level_plane
from recon.records import Box, Cylinder, PointCloud, Sphere
from recon.settings import RecognitionSettings

SETTINGS = RecognitionSettings(ground=None, catalogue="none")
UP = np.array([0.0, 1.0, 0.0])


def box(centre, sizes):
    return Box(centre=np.array(centre), axes=np.eye(3), sizes=np.array(sizes))


def cloud_of(*points):
    points = np.concatenate(points)
    return PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8))


def table_top(rng, scale=1.0, wall=False):
    """Make a box touching a can, and another can, on a table, seen from above and the front."""
    parts = [
        box([0.0, 0.1, 0.0], [0.2, 0.2, 0.15]),
        Cylinder(point=np.array([0.06, 0.0, 0.13]), axis=UP, radius=0.06, height=0.12),
        Cylinder(point=np.array([-0.4, 0.0, 0.2]), axis=UP, radius=0.05, height=0.15),
    ]
    eye = np.array([0.0, 0.7, 1.0])
    own = []
    for part in parts:
        whole = surface([part], 9000, rng)
        seen = np.einsum("ij,ij->i", whole.normals, eye - whole.points) > 0
        own.append(whole.points[seen & (whole.points[:, 1] > 0.005)])
    table = rng.uniform([-0.9, 0.0, -0.45], [0.9, 0.0, 0.45], (30_000, 3))
    backs = [rng.uniform([-0.9, 0.0, -0.45], [0.9, 0.8, -0.45], (20_000, 3))] if wall else []
    clean = [*own, table, *backs]
    return [scale * (points + 0.001 * rng.normal(size=points.shape)) for points in clean], eye


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_touching_objects_on_a_table_are_separated_in_any_unit(scale):
    pieces, eye = table_top(np.random.default_rng(0), scale)
    views = np.broadcast_to(pose(np.eye(3), scale * eye), (1, 4, 4))
    found = recognise_cloud(cloud_of(*pieces), SETTINGS, T_cloud_left=views)
    truth = np.repeat(np.arange(len(pieces)), list(map(len, pieces)))
    for number in range(3):
        own = truth == number
        overlap = max(
            ((found.label == one.id) & own).sum() / ((found.label == one.id) | own).sum()
            for one in found.objects
        )
        assert overlap > 0.7
    assert [plane.role for plane in found.planes] == ["ground"]
    assert {one.support for one in found.objects} == {0}
    assert found.planes[0].area == pytest.approx(scale**2 * 1.8 * 0.9, rel=0.4)


def test_small_thing_on_another_is_an_object_although_it_does_not_touch_the_table():
    rng = np.random.default_rng(2)
    can = Cylinder(point=np.array([0.0, 0.0, 0.0]), axis=UP, radius=0.12, height=0.15)
    ball = Sphere(centre=np.array([0.0, 0.21, 0.0]), radius=0.07)
    eye = np.array([0.0, 0.9, 1.0])
    table = rng.uniform([-0.9, 0.0, -0.45], [0.9, 0.0, 0.45], (10_000, 3))
    own = []
    for solid, count in ((can, 1800), (ball, 500)):
        whole = surface([solid], count, rng)
        is_seen = np.einsum("ij,ij->i", whole.normals, eye - whole.points) > 0
        own.append(whole.points[is_seen & (whole.points[:, 1] > 0.005)])
    clean = [*own, table]
    views = np.broadcast_to(pose(np.eye(3), eye), (1, 4, 4))
    cloud = cloud_of(*(points + 0.001 * rng.normal(size=points.shape) for points in clean))
    found = recognise_cloud(cloud, SETTINGS, T_cloud_left=views)
    truth = np.repeat(np.arange(3), list(map(len, clean)))
    label = [np.bincount(found.label[truth == number] + 1).argmax() for number in range(2)]
    assert min(label) > 0
    assert label[0] != label[1]


def test_floor_is_found_below_a_table_top_with_more_points():
    rng = np.random.default_rng(0)
    top = rng.uniform([-0.5, 0.7, -0.5], [0.5, 0.7, 0.5], (24_000, 3))
    floor = rng.uniform([-1.0, 0.0, -1.0], [1.0, 0.0, 1.0], (20_000, 3))
    points = np.concatenate([top, floor]) + rng.normal(0.0, 0.001, (44_000, 3))
    T_level = level_plane(points)
    assert T_level is not None
    assert (np.abs(transform(T_level, floor)[:, 1]) < 0.01).all()


def test_wall_is_a_separate_plane_but_the_side_of_a_box_is_not():
    with_wall, _ = table_top(np.random.default_rng(0), wall=True)
    found = recognise_cloud(cloud_of(*with_wall), SETTINGS)
    assert [plane.role for plane in found.planes] == ["ground", "wall"]
    assert found.planes[1].normal == pytest.approx([0.0, 0.0, 1.0], abs=0.05)


def test_unknown_object_is_described():
    rng = np.random.default_rng(1)
    ball = surface([Sphere(centre=np.array([0.0, 0.1, 0.0]), radius=0.1)], 3000, rng).points
    table = rng.uniform([-0.5, 0.0, -0.5], [0.5, 0.0, 0.5], (9000, 3))
    settings = RecognitionSettings(ground=None, catalogue="none", unit="m")
    (one,) = recognise_cloud(cloud_of(ball, table), settings).objects
    assert (one.label, one.probability, one.reason) == ("unknown", None, "no catalogue was asked")
    assert one.solid.solid.kind == "sphere"
    assert one.solid.solid.radius == pytest.approx(0.1, rel=0.03)
    assert one.solid.explained > 0.9
    assert one.box.sizes == pytest.approx([0.2, 0.2, 0.2], abs=0.03)
    assert one.box.unit == "m"
    assert one.colour == (120, 120, 120)
    assert one.seen > 0.7


def test_link_distance_follows_the_point_density():
    rng = np.random.default_rng(2)
    sphere = rng.normal(size=(400, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    other = np.add(sphere, [3.0, 0.0, 0.0])
    # A sparse sphere is linked across gaps that separate two dense ones.
    assert np.bincount(linked(np.concatenate([10 * sphere, [[60.0, 0, 0]]]), 1e-9)).max() > 390
    label = linked(np.concatenate([sphere, other]), 1e-9)
    assert label[0] != label[-1]


@pytest.mark.parametrize(("gap", "num_components"), [(0.98, 1), (1.02, 2)])
def test_dense_points_are_linked_up_to_the_reach_in_every_direction(gap, num_components):
    grid = np.stack(np.meshgrid(*[np.arange(0.0, 1.0, 0.25)] * 3), axis=-1).reshape(-1, 3)
    for away in np.random.default_rng(4).normal(size=(40, 3)):
        side = away / np.linalg.norm(away)
        corner, other = (grid[np.argmax(sign * grid @ side)] for sign in (1.0, -1.0))
        label = linked(np.concatenate([grid, grid - other + corner + gap * side]), 1.0)
        assert label.max() + 1 == num_components


def test_box_on_a_box_is_two_pieces_and_a_ball_is_one():
    rng = np.random.default_rng(3)
    eye = np.array([2.0, 3.0, 4.0])

    def seen(solid):
        whole = surface([solid], 6000, rng)
        return whole.points[np.einsum("ij,ij->i", whole.normals, eye - whole.points) > 0]

    stacked = [seen(box([0, 0.5, 0], [1.4, 1.0, 1.4])), seen(box([0, 1.3, 0], [0.7, 0.6, 0.7]))]
    cells = gather(cloud_of(*stacked), 0.06)
    piece = convex_pieces(relief_of(cells), eye, 12)
    lower = cells.means[:, 1] < 0.95
    assert np.bincount(piece[lower]).max() > 0.9 * lower.sum()
    assert (
        np.bincount(piece[lower]).argmax() != np.bincount(piece[cells.means[:, 1] > 1.1]).argmax()
    )
    ball = gather(cloud_of(seen(Sphere(centre=np.zeros(3), radius=0.8))), 0.06)
    assert convex_pieces(relief_of(ball), eye, 12).max() == 0


def ring_of_views(radius, beside):
    """Make views from all around the origin, and twice as many from one side."""
    turn = np.linspace(0.0, 2.0 * np.pi, 6, endpoint=False)
    ring = radius * np.column_stack([np.cos(turn), np.full(6, 0.3), np.sin(turn)])
    return np.concatenate([ring, ring + beside, ring + beside])


def test_box_and_thin_wall_seen_from_all_sides_are_one_piece_each():
    rng = np.random.default_rng(0)
    views = ring_of_views(14.0, [50.0, 0.0, 10.0])
    whole = surface([box([0.0, 3.0, 0.0], [6.0, 6.0, 8.0])], 720, rng)
    is_seen = (np.abs(whole.normals[:, 1]) < 0.5) & (whole.normals[:, 0] < 0.5)
    faces = gather(cloud_of((whole.points + rng.normal(0, 0.2, (720, 3)))[is_seen]), 1.0)
    wall = gather(cloud_of(rng.uniform([-12, 0, -0.9], [12, 5, 0.9], (900, 3))), 1.0)
    for cells in (faces, wall):
        assert fewest_pieces(relief_of(cells), views, 12).max() == 0
    assert convex_pieces(relief_of(faces), views.mean(axis=0), 12).max() > 0


def test_crown_overhangs_its_trunk_but_stacked_boxes_do_not():
    rng = np.random.default_rng(4)
    trunk, crown = (
        rng.uniform([-1, 0, -1], [1, 5, 1], (90, 3)),
        np.add(rng.normal(size=(90, 3)), [0, 8, 0]),
    )
    label = np.repeat([0, 1], 90).astype(np.int32)
    assert overhanging(np.concatenate([trunk, 3 * crown - [0, 16, 0]]), label).max() == 0
    assert overhanging(np.concatenate([4 * trunk, np.add(crown, [0, 12, 0])]), label).max() == 1
    # A box on a slightly narrower one is no crown.
    assert overhanging(np.concatenate([trunk, 1.2 * trunk + [0, 6, 0]]), label).max() == 1


def ring(num_views, reach):
    turns = np.linspace(0.0, 2.0 * np.pi * reach, num_views, endpoint=False)
    eyes = np.column_stack([3.0 * np.sin(turns), np.full(num_views, 1.0), 3.0 * np.cos(turns)])
    return np.stack([look_at(eye, [0.1, 0.2, 0.0]) for eye in eyes])


def test_ring_of_views_has_a_focus_but_a_drive_has_not():
    focus = find_focus(ring(16, 1.0))
    assert focus.centre == pytest.approx([0.1, 0.2, 0.0], abs=0.01)
    drive = np.stack([look_at([0.0, 1.0, -z], [0.0, 1.0, -z - 9.0]) for z in range(12)])
    assert find_focus(drive) is None
    assert find_focus(ring(2, 1.0)) is None


def test_focus_of_all_views_is_one_object():
    rng = np.random.default_rng(5)
    parts = [box([-0.3, 0.5, 0.0], [0.2, 1.0, 0.2]), box([0.4, 0.5, 0.0], [0.2, 1.0, 0.2])]
    cells = gather(cloud_of(surface(parts, 9000, rng).points), 0.05)
    alone = recognise(cells, SETTINGS)
    ringed = recognise(cells, SETTINGS, ring(16, 1.0))
    assert len(alone.objects) == 2
    assert [one.num_voxels for one in ringed.objects] == [len(cells)]


def test_focus_is_one_object_whatever_kinds_are_looked_for():
    rng = np.random.default_rng(0)
    parts = [
        Cylinder(point=np.array([x, 0.0, 0.0]), axis=UP, radius=0.12, height=0.4)
        for x in (-0.05, 0.25)
    ]
    cells = gather(cloud_of(surface(parts, 12_000, rng).points), 0.03)
    village = RecognitionSettings(ground=None, catalogue="village")
    assert len(recognise(cells, village).objects) == 2
    assert len(recognise(cells, village, ring(16, 1.0)).objects) == 1


def test_top_of_a_bed_in_focus_is_no_floor():
    rng = np.random.default_rng(0)
    top = rng.uniform([-0.35, 0.3, -0.3], [0.55, 0.3, 0.3], (6000, 3))
    legs = [box([0.1 + x, 0.15, z], [0.06, 0.3, 0.06]) for x in (-0.4, 0.4) for z in (-0.25, 0.25)]
    back = rng.uniform([-0.35, 0.3, -0.3], [-0.35, 0.5, 0.3], (2000, 3))
    cells = gather(cloud_of(top, back, surface(legs, 6000, rng).points), 0.03)
    found = recognise(cells, SETTINGS, ring(16, 1.0))
    assert [one.num_voxels for one in found.objects] == [len(cells)]
    assert found.planes == ()


def room(rng, top_height=0.75, is_box=False, things=2):
    """Make a floor, a table with legs or a box as large, and objects on and beside it."""
    solids = [Cylinder(point=np.array([1.1, 0.0, 0.9]), axis=UP, radius=0.12, height=0.3)]
    places = [(-0.3, 0.1), (0.35, -0.1)][:things]
    solids += [
        Cylinder(point=np.array([x, top_height, z]), axis=UP, radius=0.06, height=0.2)
        for x, z in places
    ]
    boards = []
    if is_box:
        block = box([0.0, top_height / 2.0, 0.0], [1.4, top_height, 0.8])
        boards.append(surface([block], 40_000, rng).points)
    else:
        half = [0.7, 0.0, 0.4]
        low, high = np.subtract([0.0, top_height, 0.0], half), np.add([0.0, top_height, 0.0], half)
        boards.append(rng.uniform(low, high, (9000, 3)))
        solids += [
            Cylinder(point=np.array([x, 0.0, z]), axis=UP, radius=0.03, height=top_height)
            for x in (-0.6, 0.6)
            for z in (-0.3, 0.3)
        ]
    points = [surface([one], 6000, rng).points for one in solids]
    floor = rng.uniform([-2.0, 0.0, -1.5], [2.0, 0.0, 1.5], (40_000, 3))
    return cloud_of(*(p + 0.002 * rng.normal(size=p.shape) for p in [*points, *boards, floor]))


@pytest.mark.parametrize("height", [0.45, 0.75])
def test_table_top_supports_the_objects_on_it(height):
    found = recognise_cloud(room(np.random.default_rng(6), height), SETTINGS)
    assert [plane.role for plane in found.planes] == ["ground", "support"]
    top = found.planes[1]
    assert top.point[1] == pytest.approx(height, abs=0.03)
    assert top.area == pytest.approx(1.4 * 0.8, rel=0.1)
    on_top = [one for one in found.objects if one.support == top.id]
    assert sorted(one.centre[0] for one in on_top) == pytest.approx([-0.3, 0.35], abs=0.05)
    assert [one.box.sizes[1] for one in on_top] == pytest.approx([0.2, 0.2], abs=0.06)
    (beside,) = [one for one in found.objects if one.support == 0]
    assert beside.centre[::2] == pytest.approx([1.1, 0.9], abs=0.05)


def test_bare_table_and_top_of_a_box_are_not_supports():
    rng = np.random.default_rng(7)
    for scene in (room(rng, things=0), room(rng, is_box=True)):
        assert [plane.role for plane in recognise_cloud(scene, SETTINGS).planes] == ["ground"]
