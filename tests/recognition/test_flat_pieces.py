"""Planes of one object: the right ones are found, independent of small changes."""

from dataclasses import replace
from functools import reduce

import numpy as np
import pytest

from recon.recognition.naming.assembly import assemblies
from recon.recognition.naming.catalogue import read_catalogues
from recon.recognition.naming.underside import free_below
from recon.recognition.segments.flat_pieces import LEAST_PLANE, FlatPieces, piece_of, unsplit
from recon.recognition.synthetic import voxelise
from recon.records import Plane, PointCloud, Voxels

HOUSE = next(kind for kind in read_catalogues(["village"]) if kind.name == "house")


def flat_pieces(cells, way=("any",)) -> FlatPieces:
    return reduce(FlatPieces.then, way, unsplit(cells))


def plane(corner, first, second, spacing=0.25):
    """Sample points on a parallelogram."""
    lengths = [np.linalg.norm(side) for side in (first, second)]
    a, b = (np.linspace(0.0, 1.0, int(length / spacing) + 1) for length in lengths)
    grid = np.stack(np.meshgrid(a, b), axis=-1).reshape(-1, 2)
    return np.array(corner) + grid @ np.array([first, second], dtype=float)


def cells_of(*planes, noise=0.08) -> Voxels:
    points = np.concatenate(planes)
    points = points + np.random.default_rng(0).normal(0.0, noise, points.shape)
    return voxelise(PointCloud(points=points, colours=np.full(points.shape, 90, np.uint8)))


def walls():
    return [
        plane([0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 6.0, 0.0]),
        plane([0.0, 0.0, 8.0], [10.0, 0.0, 0.0], [0.0, 6.0, 0.0]),
        plane([0.0, 0.0, 0.0], [0.0, 0.0, 8.0], [0.0, 6.0, 0.0]),
    ]


def slope(height):
    """Make a plane of 37 degrees from one long wall to the middle."""
    return plane([0.0, height, 0.0], [10.0, 0.0, 0.0], [0.0, 3.0, 4.0])


def test_planes_of_walls_and_a_slope_are_found_with_their_tilts():
    found = flat_pieces(cells_of(*walls(), slope(6.0)))
    tilts = sorted(one.tilt_deg for one in found.planes if len(one.rows) > 20)
    assert tilts == pytest.approx([36.9, 90.0, 90.0, 90.0], abs=4.0)


def house_without_visible_slopes(rise):
    """Sample four walls, gables of some height and the ridge, but not the slopes."""
    gable = plane([0.0, 0.0, 0.0], [0.0, 0.0, 8.0], [0.0, 5.0 + rise, 0.0])
    inside = gable[:, 1] - 5.0 <= rise * (1.0 - np.abs(gable[:, 2] - 4.0) / 4.0)
    gables = [gable[inside] + [x, 0.0, 0.0] for x in (0.0, 12.0)]
    sides = [plane([0.0, 0.0, z], [12.0, 0.0, 0.0], [0.0, 5.0, 0.0]) for z in (0.0, 8.0)]
    ridge = np.array([0.0, 5.0 + rise, 4.0]) + np.linspace(0.0, 12.0, 200)[:, None] * [1, 0, 0]
    return [*gables, *sides, ridge]


def test_unseen_roof_slopes_are_found_from_walls_and_ridge():
    found = flat_pieces(cells_of(*house_without_visible_slopes(4.0)), ("outer", "upright"))
    tilts = [one.tilt_deg for one in found.planes]
    # 45 degrees, but the tops of the walls are within reach as well.
    assert tilts[:2] == pytest.approx([50.0, 50.0], abs=8.0)
    assert found.planes[0].solid.normal[2] * found.planes[1].solid.normal[2] < 0.0
    assert len(tilts) >= 5
    assert tilts[2:] == pytest.approx([90.0] * len(tilts[2:]))


@pytest.mark.parametrize(
    "what", [house_without_visible_slopes(0.0), [*walls(), slope(6.0)]], ids=["box", "one slope"]
)
def test_box_and_single_slope_get_no_unseen_roof(what):
    assert not flat_pieces(cells_of(*what), ("outer",)).planes


def slice_of(cells, low):
    """The cells of some height as a level piece."""
    rows = np.flatnonzero((cells.means[:, 1] >= low) & (cells.means[:, 1] < low + 1.0))
    level = Plane(point=cells.means[rows[0]], normal=np.array([0.0, 1.0, 0.0]))
    return piece_of(cells, rows, level)


def test_a_board_is_free_below_and_a_slice_of_a_wall_is_not_even_near_the_ground():
    wall = cells_of(plane([0.0, 1.0, 0.0], [15.0, 0.0, 0.0], [0.0, 5.0, 0.0]), noise=0.3)
    assert [free_below(slice_of(wall, low), wall) for low in (1.0, 3.0)] == pytest.approx(
        [0.0, 0.0], abs=0.15
    )
    board = plane([0.0, 3.5, 0.0], [8.0, 0.0, 0.0], [0.0, 0.0, 6.0])
    table = cells_of(board, plane([1.0, 1.0, 1.0], [0.5, 0.0, 0.0], [0.0, 2.5, 0.0]))
    assert free_below(slice_of(table, 3.0), table) > 0.9


def test_noise_of_few_points_closes_nothing_below_a_board():
    board = plane([0.0, 3.5, 0.0], [8.0, 0.0, 0.0], [0.0, 0.0, 6.0])
    noise = plane([0.0, 1.5, 0.0], [8.0, 0.0, 0.0], [0.0, 0.0, 6.0])
    cells = cells_of(board, noise)
    is_low = cells.means[:, 1] < 3.0
    for count, is_free in ((3, True), (10, False)):
        scanned = replace(cells, counts=np.where(is_low, count, 16))
        assert (free_below(slice_of(scanned, 3.0), scanned) > 0.9) == is_free


def explained(*planes):
    """How well a house explains planes; 0 if it has not its parts among them."""
    found = assemblies([flat_pieces(cells_of(*planes), ("upright", "any"))], HOUSE, 0.0)
    return max((one.explained for one in found), default=0.0)


def test_walls_of_a_house_are_at_right_angles():
    sides = [[10.0, 0.0, 0.0], [-5.0, 0.0, 8.66], [-5.0, 0.0, -8.66]]
    corners = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [5.0, 0.0, 8.66]]
    tent = [plane(at, side, [0.0, 6.0, 0.0]) for at, side in zip(corners, sides, strict=True)]
    assert explained(*walls(), slope(6.0)) > 0.9
    assert explained(*tent, slope(6.0)) < 0.1


def test_two_sides_of_a_hedge_are_no_walls_of_a_house():
    other = slope(6.0) * [1.0, 1.0, -1.0] + [0.0, 0.0, 8.0]
    assert explained(*walls()[:2], slope(6.0), other) < 0.1
    assert explained(*walls(), slope(6.0), other) > 0.9


def test_a_few_slanted_cells_are_no_roof():
    edge = plane([0.0, 6.0, 0.0], [4.0, 0.0, 0.0], [0.0, 1.5, 2.0])
    assert explained(*walls(), edge) == 0.0


def lump(seed) -> Voxels:
    """Cells around one place, as many as a bush has."""
    rng = np.random.default_rng(seed)
    points = rng.normal(0.0, rng.uniform(0.3, 6.0, 3), (60, 3))
    index = np.floor(points).astype(np.int64)
    counts = np.full(len(points), 9)
    return Voxels(index=index, centres=index + 0.5, means=points, counts=counts, cell_size=1.0)


def test_a_slope_has_enough_points_that_the_other_has_not():
    found = [flat_pieces(lump(seed), ("outer",)).planes for seed in range(80)]
    assert any(found)
    assert min(len(one.rows) for planes in found for one in planes) >= LEAST_PLANE


def test_small_changes_of_cells_do_not_change_planes():
    cells = cells_of(*walls(), slope(6.0))
    found = flat_pieces(cells, ("upright", "any"))
    assert len(found.planes) > 1
    for seed in range(6):
        moved = np.random.default_rng(seed).normal(0.0, 0.01, cells.means.shape)
        again = flat_pieces(replace(cells, means=cells.means + moved), ("upright", "any"))
        assert len(again.planes) == len(found.planes)
        for one, other in zip(found.planes, again.planes, strict=True):
            assert len(np.intersect1d(one.rows, other.rows)) > 0.85 * len(one.rows)


def test_level_plane_is_found_from_its_rim_alone():
    angle = np.linspace(0.0, 2.0 * np.pi, 400)
    rim = np.column_stack([5.0 * np.cos(angle), np.full(400, 2.5), 5.0 * np.sin(angle)])
    found = flat_pieces(cells_of(rim, noise=0.05))
    assert found.planes[0].tilt_deg < 5.0
    assert len(found.planes[0].rows) > 0.9 * len(found.cells)


def test_slope_between_walls_is_a_roof_only_on_top():
    on_top = flat_pieces(cells_of(*walls(), slope(6.0)), ("upright", "any"))
    inside = flat_pieces(cells_of(*walls(), slope(1.5)), ("upright", "any"))
    assert assemblies([on_top], HOUSE, 0.0)
    assert not assemblies([inside], HOUSE, 0.0)
