"""Knowledge about the floor gained from views."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.errors import InputError
from recon.exploration.floor import Floor, check_floor
from recon.settings import Settings, updated


def seen(floor, place, heading_deg, reach=30.0):
    rays = floor.azimuths(np.radians(heading_deg), np.radians(80.0), reach)
    floor.see(np.array(place), rays, np.full(len(rays), reach))
    return floor.known_free


def is_known(floor, x, z):
    return bool(floor.known_free[tuple(floor.cells([x, z]))])


@settings(max_examples=30)
@given(st.integers(1, 60), st.integers(1, 60))
def test_cells_and_their_centres_are_inverse(size_x, size_z):
    floor = Floor(size_x=size_x, size_z=size_z)
    cells = np.argwhere(~floor.occupied)
    assert np.array_equal(floor.cells(floor.centres(cells)), cells)
    assert floor.holds(cells).all()
    assert np.array_equal(floor.flat(cells), np.arange(size_x * size_z))
    assert floor.flat(np.array([size_x, 0])) == size_x * size_z


def test_view_makes_only_its_field_known():
    floor = Floor(size_x=100, size_z=100)
    known = seen(floor, (0.0, 0.0), 0.0)
    area = 0.5 * np.radians(80.0) * 30.0**2
    assert 0.97 * area < known.sum() < 1.1 * area
    assert floor.known_share == pytest.approx(known.mean())
    floor.occupied[:, :10] = True
    assert floor.known_share == pytest.approx(known.mean() + 0.1, abs=0.01)
    assert is_known(floor, 20, 0)
    assert is_known(floor, 20, 15)
    assert not is_known(floor, -5, 0)
    assert not is_known(floor, 10, 12)
    assert not is_known(floor, 32, 0)


def test_azimuth_of_a_quarter_turn_is_along_z():
    floor = Floor(size_x=100, size_z=100)
    seen(floor, (0.0, 0.0), 90.0)
    assert is_known(floor, 0, 20)
    assert not is_known(floor, 0, -20)


@pytest.mark.parametrize("stands", [True, False])
def test_obstacle_hides_the_floor_behind_it(stands):
    floor = Floor(size_x=100, size_z=100)
    if stands:
        floor.occupied |= floor.disc(np.array([15.0, 0.0]), 3.0)
    seen(floor, (0.0, 0.0), 0.0)
    assert is_known(floor, 10, 0)
    assert is_known(floor, 25, 12)
    assert is_known(floor, 25, 0) is not stands


def test_limits_end_the_rays():
    floor = Floor(size_x=100, size_z=100)
    rays = floor.azimuths(0.0, np.radians(80.0), 30.0)
    floor.see(np.zeros(2), rays, np.where(rays > 0, 5.0, 30.0))
    assert is_known(floor, 20, -5)
    assert not is_known(floor, 20, 5)


def test_overhang_hides_nothing():
    floor = Floor(size_x=100, size_z=100)
    floor.occupied |= floor.disc(np.zeros(2), 3.0)
    seen(floor, (0.0, 0.0), 0.0)
    assert is_known(floor, 20, 0)


def test_nearest_view_of_a_cell_is_kept():
    floor = Floor(size_x=100, size_z=100)
    seen(floor, (0.0, 0.0), 0.0)
    seen(floor, (10.0, 0.0), 0.0)
    seen(floor, (0.0, 0.0), 0.0)
    assert 9.0 <= floor.seen_from[tuple(floor.cells([20.0, 0.0]))] <= 10.5


@pytest.mark.parametrize(
    ("num_points", "free_from", "holds"), [(2, 80.0, True), (2, 20.0, False), (1, 80.0, False)]
)
def test_points_outweigh_free_ground_seen_from_much_farther(num_points, free_from, holds):
    floor = Floor(size_x=100, size_z=100)
    post = np.array([12.5, 9.5])
    floor.seen_from[:] = free_from
    floor.hit_at(np.zeros(2), np.array([*[post] * num_points, [60.0, 0.0], [60.0, 0.0]]))
    assert floor.hit.sum() == holds
    assert floor.hit[tuple(floor.cells(post))] == holds
    assert floor.window(post, 3.0).hit.sum() == holds


@pytest.mark.parametrize(("size", "cell_size"), [(1e5, 1.0), (5000.0, 0.05), (1e300, 1.0)])
def test_too_large_floor_is_rejected_before_allocation(size, cell_size):
    changes = {"world": {"size_x": size, "size_z": size}, "map": {"cell_size": cell_size}}
    with pytest.raises(InputError, match=r"world\.size_x.*at most 16000000 cells"):
        check_floor(updated(Settings(), changes))


@pytest.mark.parametrize(("sight_range", "cell_size"), [(1e9, 1.0), (1001.0, 1.0), (101.0, 0.05)])
def test_too_long_range_of_sight_is_rejected_before_allocation(sight_range, cell_size):
    changes = {"exploration": {"sight_range": sight_range}, "map": {"cell_size": cell_size}}
    changes["world"] = {"size_x": 100.0, "size_z": 10.0}
    with pytest.raises(InputError, match=r"exploration\.sight_range is .* but at most"):
        check_floor(updated(Settings(), changes))
    wide = {
        "world": {"size_x": 2e9, "size_z": 0.001},
        "map": {"cell_size": 1000.0},
        "motion": {"body_radius": 1e3},
    }
    check_floor(updated(Settings(), changes | wide))


@pytest.mark.parametrize(
    ("motion", "fault"),
    [
        ({"position_noise": 1e9}, "motion.position_noise is 1e.09, but at most 1000 is possible"),
        ({"body_radius": 1e-9}, "motion.body_radius is 1e-09, but at least 0.0001 is needed"),
    ],
)
def test_motion_that_does_not_suit_the_floor_is_rejected(motion, fault):
    with pytest.raises(InputError, match=fault):
        check_floor(updated(Settings(), {"motion": motion}))


def test_window_shares_its_cells_with_the_floor():
    floor = Floor(size_x=60, size_z=40, cell_size=0.5)
    part = floor.window(np.array([28.0, 3.2]), 4.0)
    assert part.shape == (12, 17)
    assert np.allclose(part.corner, [24.0, -1.0])
    point = np.array([26.3, 4.9])
    part.occupied[tuple(part.cells(point))] = True
    assert np.argwhere(floor.occupied).tolist() == [floor.cells(point).tolist()]
    assert np.allclose(part.centres(part.cells(point)), floor.centres(floor.cells(point)))
    assert not part.holds(part.cells([23.0, 0.0]))
    assert floor.window(np.zeros(2), 100.0).shape == floor.shape


def test_visible_cells_do_not_depend_on_the_size_of_the_floor():
    small, large = Floor(size_x=60, size_z=60), Floor(size_x=300, size_z=300)
    for floor in (small, large):
        seen(floor, [2.5, 1.5], 30.0, reach=20.0)
    assert small.known_free.sum() == large.known_free.sum() > 100
