"""Positions in a figure: viewpoints, names, footprints, scales."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from recon.errors import InputError
from recon.figures import names, scales
from recon.figures.cover import BLOCK_PX, Cover
from recon.figures.footprints import least_rectangle, of_object, of_solid
from recon.figures.frame import step_of, ticks
from recon.figures.geojson import feature_collection
from recon.figures.kinds import Subject
from recon.figures.occupancy import labels
from recon.figures.partition import NO_OBJECT, owners
from recon.figures.viewpoint import VIEWS, viewpoint
from recon.geometry import look_at, rotation_about_y
from recon.records import (
    Box,
    Cone,
    Cylinder,
    Ellipsoid,
    Plane,
    Reconstruction,
    Sphere,
    Trajectory,
    TruncatedCone,
    Voxels,
)
from recon.voxelmap import VoxelMap

SIZE = (800, 600)
BOX = np.array([-20.0, 0.0, -35.0]), np.array([30.0, 16.0, 25.0])
UP = np.array([0.0, 1.0, 0.0])


def corners(low, high):
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1])
                     for z in (low[2], high[2])])  # fmt: skip


@pytest.mark.parametrize("view", [view for view in VIEWS if view != "camera"])
def test_whole_box_is_inside_the_image(view):
    first = look_at((0.0, 5.0, 60.0), (0.0, 5.0, 0.0))
    at = viewpoint(view, BOX, SIZE, first).project(corners(*BOX), SIZE)
    assert (at[:, 2] > 0).all()
    assert (at[:, :2] >= 0).all()
    assert (at[:, :2] <= SIZE).all()
    assert np.ptp(at[:, :2], axis=0).max() > 0.5 * min(SIZE)


def test_camera_view_is_that_of_the_first_camera():
    first = look_at((0.0, 5.0, 60.0), (0.0, 5.0, 0.0))
    at = viewpoint("camera", BOX, SIZE, first).project([[0.0, 5.0, 0.0]], SIZE)
    np.testing.assert_allclose(at, [[400.0, 300.0, 60.0]], atol=1e-9)
    with pytest.raises(InputError, match="there is no camera"):
        viewpoint("ego", BOX, SIZE, None)


def test_six_numbers_are_position_and_target():
    at = viewpoint("3,4,5,1,2,0", BOX, SIZE).project([[1.0, 2.0, 0.0]], SIZE)
    np.testing.assert_allclose(at[0, :2], [400.0, 300.0], atol=1e-9)
    down = viewpoint("3,40,5,3,0,5", BOX, SIZE).project([[3.0, 0.0, 5.0]], SIZE)
    np.testing.assert_allclose(down[0, :2], [400.0, 300.0], atol=0.1)
    for view in ("1,2", "1,2,x", "nan,1,2", "inf,1,2", "1e300,0,0", "1,2,3,4"):
        with pytest.raises(InputError, match="or x,y,z or x,y,z,x,y,z is needed"):
            viewpoint(view, BOX, SIZE)


@given(low=st.floats(-1e4, 1e4), extent=st.floats(1e-3, 1e4))
def test_ticks_are_round_and_inside(low, extent):
    box = np.full(3, low), np.full(3, low + extent)
    step = step_of(box)
    assert 2.0 <= extent / step <= 10.0
    places = ticks(low, low + extent, step)
    assert len(places) >= 2
    assert places[0] >= low - 1e-6 * step
    assert places[-1] <= low + extent + 1e-6 * step


def test_names_overlap_nothing_if_there_is_space():
    boxes = np.array([[100, 100, 150, 150], [160, 100, 210, 150], [110, 40, 200, 90]], float)
    wanted = [names.Name(text="a", box=box) for box in boxes]
    sizes = np.tile([60.0, 20.0], (3, 1))
    placed = names.place(wanted, sizes, np.array([0, 0, 400, 400.0]), 15.0)
    every = np.vstack([boxes, placed])
    for number, box in enumerate(placed):
        others = np.delete(every, 3 + number, axis=0)
        width = np.minimum(box[2], others[:, 2]) - np.maximum(box[0], others[:, 0])
        height = np.minimum(box[3], others[:, 3]) - np.maximum(box[1], others[:, 1])
        assert not ((width > 1e-9) & (height > 1e-9)).any()


def test_names_stay_inside_the_image():
    edge = [names.Name(text="a", box=np.array([0.0, 0.0, 5.0, 5.0]))]
    (box,) = names.place(edge, np.array([[60.0, 20.0]]), np.array([0, 0, 400, 300.0]), 15.0)
    assert (box[:2] >= 0).all()


def test_covered_area_is_that_of_the_dots():
    cover = Cover(np.array([[100.0, 50.0]]), 10.0, (300, 200))
    areas = cover.area(np.array([[90, 40, 110, 60], [0, 0, 60, 30], [0, 0, 300, 200.0]]))
    dot, around = np.pi * 10.0**2, (20.0 + 2 * BLOCK_PX) ** 2
    assert dot < areas[0] < around
    assert areas[1] == 0
    assert areas[0] <= areas[2] < around


def area(ring):
    x, y = ring.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.mark.parametrize(
    ("solid", "truth"),
    [
        (Sphere(centre=np.array([1.0, 2, 3]), radius=2.0), np.pi * 4),
        (Cylinder(point=np.zeros(3), axis=UP, radius=3.0, height=5.0), np.pi * 9),
        (Cone(apex=np.array([0, 8.0, 0]), axis=-UP, half_angle_rad=np.pi / 4, height=2.0),
         np.pi * 4),
        (TruncatedCone(point=np.zeros(3), axis=UP, radius_bottom=7.0, radius_top=1.0, height=4.0),
         np.pi * 49),
        (Box(centre=np.zeros(3), axes=rotation_about_y(0.4), sizes=np.array([2.0, 5, 3])), 6.0),
        (Ellipsoid(centre=np.zeros(3), radii=np.array([4.0, 3, 2]), axes=np.eye(3)), np.pi * 8),
    ],
    ids=lambda value: getattr(value, "kind", ""),
)  # fmt: skip
def test_footprints_have_the_area_of_their_solids(solid, truth):
    ring = of_solid(solid)
    # Counter-clockwise with north up, as GeoJSON requires: in x, z the area is negative.
    assert area(ring * (1.0, -1.0)) == pytest.approx(truth, rel=0.01)


@pytest.mark.parametrize("scale", [0.01, 1.0, 100.0])
def test_owner_of_a_point_is_the_smallest_object_around_it_in_any_unit(ball, scale):
    from dataclasses import replace

    def thing(number, size):
        return replace(ball, id=number, centre=np.zeros(3), size=np.full(3, scale * size))

    points = scale * np.array([[0.0, 0, 0], [1.45, 0, 0], [1.55, 0, 0], [3.55, 0, 0], [np.nan] * 3])
    for objects in ([thing(7, 2.8), thing(4, 7.0)], [thing(4, 7.0), thing(7, 2.8)]):
        found = owners(points, objects, 0.1 * scale)
        assert found.tolist() == [7, 7, 4, 4, NO_OBJECT]
    assert owners(points, objects, 0.01 * scale).tolist() == [7, 4, 4, NO_OBJECT, NO_OBJECT]


@given(st.floats(1e-9, 1e9))
def test_length_of_a_scale_bar_is_round_and_not_longer_than_wanted(most):
    length = scales.round_length(most)
    assert 0.4 * most <= length <= most * (1 + 1e-9)
    assert f"{length:.0e}"[0] in "125"


def test_plane_has_no_footprint():
    assert of_solid(Plane(point=np.zeros(3), normal=UP)).shape == (0, 2)


def test_smallest_rectangle_aligns_with_its_points():
    rng = np.random.default_rng(0)
    turn = rotation_about_y(0.6)[np.ix_([0, 2], [0, 2])]
    points = (rng.random((500, 2)) * (10.0, 2.0)) @ turn.T
    assert abs(area(least_rectangle(points))) == pytest.approx(20.0, rel=0.05)


def test_object_without_solids_has_the_footprint_of_its_cells(voxels, ball):
    from dataclasses import replace

    ring = of_object(replace(ball, parts=()), voxels)
    assert len(ring) >= 2
    np.testing.assert_allclose(ring.mean(axis=0), [10.5, 0.5], atol=0.6)


def test_geojson_has_north_up_and_closed_rings(voxels, ball):
    way = np.tile(np.eye(4), (2, 1, 1))
    way[1, 2, 3] = -8.0
    document = feature_collection(voxels, [ball], way, "m")
    json.dumps(document, allow_nan=False)
    polygon, line = document["features"]
    (ring,) = polygon["geometry"]["coordinates"]
    assert ring[0] == ring[-1]
    assert area(np.array(ring)) == pytest.approx(np.pi * 4, rel=0.01)
    assert polygon["properties"]["label"] == "pine tree"
    assert polygon["properties"]["centre"] == [10.5, -0.5]
    assert line["geometry"]["coordinates"] == [[0.0, 0.0], [0.0, 8.0]]


def luminance(colours):
    linear = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


@pytest.mark.parametrize("name", [scales.COUNT, scales.ERROR, scales.ORDER, "disparity", "error"])
def test_colour_maps_rise_in_lightness(name):
    from matplotlib import colormaps

    own = {"disparity": scales.disparity, "error": scales.error}
    scale = own[name]() if name in own else colormaps[name]
    assert (np.diff(luminance(scale(np.linspace(0, 1, 64))[:, :3])) > 0).all()


def test_rainbow_colour_map_does_not_rise_in_lightness():
    from matplotlib import colormaps

    assert (np.diff(luminance(colormaps["turbo"](np.linspace(0, 1, 64))[:, :3])) < 0).any()


def test_outliers_lie_beyond_the_scale():
    values = np.concatenate([np.linspace(0, 10, 1000), [500.0]])
    low, high = scales.ends(values)
    assert 0 <= low < 0.2
    assert 9.8 < high < 11
    assert scales.beyond(values, low, high) == "both"
    assert scales.ends(np.zeros(0)) == (0.0, 1.0)


def test_observed_ground_is_free_and_obstacles_on_it_are_occupied():
    from recon.figures.free_ground import states_by_ground
    from recon.voxelmap.ground import FREE, OCCUPIED, UNKNOWN

    x, z = np.meshgrid(np.arange(20), np.arange(15), indexing="ij")
    floor = np.stack([x, np.full_like(x, -3), z], axis=-1).reshape(-1, 3)
    wall = np.array([[5, y, place] for y in range(-2, 6) for place in range(15)])
    index = np.vstack([floor[floor[:, 0] != 12], wall])
    voxels = Voxels(
        index=index, centres=index + 0.5, means=index + 0.5, counts=np.ones(len(index), int),
        colours=np.zeros((len(index), 3), np.uint8), cell_size=1.0,
    )  # fmt: skip
    states = states_by_ground(voxels)
    assert (states.cells[5] == OCCUPIED).all()
    assert (states.cells[12] == UNKNOWN).all()
    assert (states.cells[[0, 4, 6, 19]] == FREE).all()
    np.testing.assert_array_equal(states.origin_xz, [0.0, 0.0])
    assert states_by_ground(voxels.select(slice(0))) is None


@pytest.mark.parametrize(("x", "corner"), [(0, "right"), (40, "left")])
def test_north_arrow_is_placed_in_an_empty_corner(voxels, x, corner):
    # Cells at the top on one side only.
    index = np.array([[x + a, 0, b] for a in range(8) for b in range(8)] + [[20, 0, 40]])
    cells = Voxels(
        index=index, centres=index + 0.5, means=index + 0.5, counts=np.full(len(index), 9),
        colours=np.full((len(index), 3), 99, np.uint8), cell_size=1.0,
    )  # fmt: skip
    ahead = np.diag([1.0, -1.0, -1.0, 1.0])
    ahead[:3, 3] = 20.0, 0.0, 38.0
    figure = labels(cells, trajectory=ahead[None])
    (north,) = [text for text in figure.axes[0].texts if text.get_text() == "N"]
    assert (north.get_position()[0] > 0.5) == (corner == "right")
    assert north.get_position()[1] > 0.5


def test_map_of_rays_that_saw_nothing_has_no_floor():
    empty = VoxelMap(1.0, channels=["rays"])
    nothing = Trajectory(stamps_s=np.zeros(0), T_world_left=np.zeros((0, 4, 4)))
    run = Reconstruction(map=empty, voxels=empty.occupied(), objects=(), trajectory=nothing)
    assert Subject(run=run).states is None
