"""Shortest paths around obstacles, viewpoints, and unexplored ground."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt
from scipy.spatial.distance import cdist

from recon.exploration.floor import Floor
from recon.exploration.obstacles import Obstacle, covered_by
from recon.exploration.paths import ShortestPaths, near_to, plan, unexplored
from recon.exploration.scales import Scales
from recon.exploration.scan import Detection
from recon.exploration.state import State
from recon.exploration.viewpoints import vantage_points, viewpoint
from recon.exploration.wave import shortest
from recon.records import View, Voxels
from recon.settings import Settings

CLEARANCE = Settings().exploration.walk_clearance


def state_on(floor, place=(0.0, 0.0), detections=()):
    x, z = place
    return State(
        num_pairs=1,
        view=View(position=np.array([x, 5.0, z]), target=np.array([x, 5.0, z - 10.0])),
        pair=None,
        voxel_map=None,
        floor=floor,
        obstacles=(),
        detections=tuple(detections),
        refuted=(),
        sure_range=20.0,
        objects=(),
        simulator=None,
        settings=Settings(),
    )


@pytest.fixture
def floor():
    """A floor known to be free, with a wall from (10, -20) to (10, 20)."""
    floor = Floor(size_x=80, size_z=80)
    floor.seen_from[:] = 1.0
    floor.occupied[50, 20:61] = True
    return floor


def planned(state):
    return plan(state, unexplored(state.floor, state.obstacles))


def length_of(paths: ShortestPaths, end):
    corners = np.vstack([paths.place, paths.corners(end), end])
    return np.linalg.norm(np.diff(corners, axis=0), axis=1).sum(), corners


def obstacle_at(x, z, radius, floor):
    cells = np.argwhere(floor.disc(np.array([x, z]), radius))
    none = np.empty((0, 3))
    return Obstacle(
        cells=cells,
        covered=covered_by(cells),
        centre=np.array([x, z]),
        radius=radius,
        top=8.0,
        voxels=Voxels(
            index=none.astype(np.int64), centres=none, means=none,
            counts=np.empty(0, dtype=np.int64), colours=none.astype(np.uint8), cell_size=1.0,
        ),
        bearings_rad=np.empty(0),
        away=np.empty(0),
        is_whole=np.empty(0, dtype=bool),
    )  # fmt: skip


def test_path_keeps_its_distance_around_a_wall(floor):
    end = np.array([20.0, 0.0])
    length, corners = length_of(planned(state_on(floor)), end)
    around = 2 * np.hypot(10.5, 20.0)
    assert around < length < 1.25 * around
    wall = floor.centres(np.argwhere(floor.occupied))
    for a, b in itertools.pairwise(corners):
        samples = a + np.linspace(0, 1, 200)[:, None] * (b - a)
        away = np.linalg.norm(samples[:, None] - wall, axis=-1).min()
        assert away > CLEARANCE - 1.0


@pytest.mark.parametrize("seed", range(3))
def test_shortest_paths_match_an_exhaustive_search(seed):
    rng = np.random.default_rng(seed)
    walkable = rng.uniform(size=(23, 31)) < 0.7
    walkable[:2, :2] = [[True, False], [False, False]]
    start = tuple(int(n) for n in np.argwhere(walkable)[5])
    distance, before = shortest(walkable, start)
    plain = searched(walkable, start)
    assert np.allclose(distance, plain)
    assert np.isinf(distance[0, 0])
    for cell in map(tuple, np.argwhere(np.isfinite(plain) & (plain > 0))):
        step = np.hypot(*(before[cell] - cell))
        assert distance[cell] == pytest.approx(distance[tuple(before[cell])] + step)


def searched(walkable, start):
    """Compute distances by sweeping over all cells until nothing changes."""
    distance = np.full(np.array(walkable.shape) + 2, np.inf)
    distance[start[0] + 1, start[1] + 1] = 0.0
    inner, last = distance[1:-1, 1:-1], None
    while last is None or not np.array_equal(inner, last):
        last = inner.copy()
        for i, j in itertools.product((-1, 0, 1), repeat=2):
            rows, columns = distance.shape
            beside = distance[1 + i : rows - 1 + i, 1 + j : columns - 1 + j]
            inner[walkable] = np.minimum(inner, beside + np.hypot(i, j))[walkable]
    return inner


def test_path_over_open_ground_is_straight(floor):
    paths = planned(state_on(floor))
    end = np.array([-31.3, 17.2])
    length, corners = length_of(paths, end)
    assert len(corners) == 2
    assert length == pytest.approx(np.hypot(*end))
    assert paths.length(end[None])[0] == pytest.approx(length, rel=0.1)


def test_enclosed_cells_are_unreachable(floor):
    floor.occupied |= floor.disc(np.array([-20.0, 0.0]), 12.0)
    floor.occupied &= ~floor.disc(np.array([-20.0, 0.0]), 10.0)
    paths = planned(state_on(floor))
    assert not paths.reaches(np.array([[-20.0, 0.0], [90.0, 0.0]])).any()
    assert paths.reaches(np.array([[-20.0, 30.0]])).all()


def test_unknown_ground_is_crossed_only_on_request(floor):
    floor.seen_from[:30] = np.inf
    end = np.array([[-20.0, 0.0]])
    assert not planned(state_on(floor)).reaches(end)[0]
    assert plan(state_on(floor), None).reaches(end)[0]


def test_sightings_block_the_path(floor):
    ghost = Detection(centre=np.array([-20.0, 0.0]), radius=4.0, distance=20.0, sigma=1.0)
    assert planned(state_on(floor)).is_clear(np.zeros(2), np.array([-30.0, 0.0]))
    paths = planned(state_on(floor, detections=[ghost]))
    assert not paths.is_clear(np.zeros(2), np.array([-30.0, 0.0]))
    assert paths.reaches(np.array([[-30.0, 0.0]]))[0]


def test_points_too_few_for_the_map_still_block_the_path(floor):
    pale, end = np.array([-20.5, 0.5]), np.array([-30.0, 0.0])
    floor.hit_at(np.zeros(2), np.array([pale, pale]))
    assert planned(state_on(floor)).is_clear(np.zeros(2), end)
    floor.seen_from[:] = 50.0
    assert not planned(state_on(floor)).is_clear(np.zeros(2), end)
    walked = floor.centres(np.argwhere(np.isfinite(planned(state_on(floor)).distance)))
    clearance = state_on(floor).scales.unknown_clearance
    assert clearance <= np.hypot(*(walked - pale).T).min() < clearance + 1.0


def closest_walk(floor, points_xz):
    walked = floor.centres(np.argwhere(np.isfinite(planned(state_on(floor)).distance)))
    return cdist(walked, np.reshape(points_xz, (-1, 2))).min()


def test_unknown_ground_is_given_more_room_beside_an_obstacle(floor):
    scales = state_on(floor).scales
    hidden, open_ground = np.zeros((2, *floor.shape), dtype=bool)
    hidden[46:50, 61:66] = True
    open_ground[10:14, 40:45] = True
    floor.seen_from[hidden | open_ground] = np.inf
    room = closest_walk(floor, floor.centres(np.argwhere(open_ground)))
    assert scales.unknown_clearance <= room < scales.walk_clearance
    beside = np.argwhere(hidden & floor.disc(np.array([10.0, 20.0]), 4.0))
    assert closest_walk(floor, floor.centres(beside)) >= scales.walk_clearance


def test_path_can_leave_a_place_too_near_an_obstacle(floor):
    paths = planned(state_on(floor, place=(9.0, 0.0)))
    assert paths.reaches(np.array([[-20.0, 0.0]]))[0]


@pytest.mark.parametrize("radius", [0.5, 4.0])
def test_path_can_leave_a_place_of_contact(floor, radius):
    floor.touch(np.zeros(2), radius)
    paths = planned(state_on(floor))
    assert paths.reaches(np.array([[-20.0, 0.0]]))[0]
    assert not planned(state_on(floor, place=(-20.0, 0.0))).reaches(np.zeros((1, 2)))[0]


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 5.0))
def test_dilation_matches_the_distance_transform(seed, distance):
    rng = np.random.default_rng(seed)
    cells = rng.random((20, 30)) < rng.choice([0.02, 0.3, 0.9])
    cells[rng.integers(20), rng.integers(30)] = True
    assert np.array_equal(near_to(cells, distance), distance_transform_edt(~cells) < distance)


def test_interior_of_obstacles_and_narrow_gaps_are_not_unexplored():
    floor = Floor(size_x=80, size_z=80)
    floor.seen_from[:] = 1.0
    tree = obstacle_at(10.0, 0.0, 8.0, floor)
    floor.seen_from[floor.disc(np.array([10.0, 0.0]), 6.0)] = np.inf
    floor.seen_from[5, 5:8] = np.inf
    floor.seen_from[:6, 60:] = np.inf
    assert np.array_equal(unexplored(floor, [tree]), np.isinf(floor.seen_from) & lower_right(floor))
    assert unexplored(floor, []).sum() > unexplored(floor, [tree]).sum()


def lower_right(floor):
    mask = np.zeros(floor.shape, dtype=bool)
    mask[:6, 60:] = True
    return mask


def test_blocked_place_around_an_obstacle_is_moved_instead_of_dropped(floor):
    tree = obstacle_at(-5.0, 0.0, 3.0, floor)
    free = viewpoint(planned(state_on(floor, (-5.0, 25.0))), tree, np.pi, 10.0)
    assert np.allclose(free, [-18.0, 0.0])
    blocked = viewpoint(planned(state_on(floor, (-5.0, 25.0))), tree, 0.0, 10.0)
    assert blocked is not None
    assert 0.0 < blocked[0] < 10.5 - CLEARANCE + 1.0
    barred = obstacle_at(36.0, 0.0, 3.9, floor)
    assert viewpoint(planned(state_on(floor)), barred, 0.0, 10.0) is None


def test_viewpoints_are_reachable_and_see_the_frontier(floor):
    floor.seen_from[60:] = np.inf
    paths, unknown = planned(state_on(floor)), unexplored(floor, [])
    places = vantage_points(paths, unknown, Scales.of(Settings()))
    assert paths.reaches(places).all()
    assert places[:, 0].max() > 15.0
    assert 10 < len(places) < 200
