"""The voxel map: what it counts, and that order, chunks and merging do not change a bit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.errors import InputError
from recon.notices import collected_notices
from recon.voxelmap import VoxelMap
from tests.voxelmap.clouds import cloud, filled, random_cloud


def same(a, b):
    names = ("index", "centres", "means", "counts", "colours")
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names)


def test_counts_means_and_colours_match_the_points():
    points = random_cloud(np.random.default_rng(1))
    voxels = filled(points, cell_size=0.7).occupied(min_count=1)
    cells = np.floor(points.points / 0.7).astype(int)
    index, inverse, counts = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    assert np.array_equal(voxels.index, index)
    assert np.array_equal(voxels.counts, counts)
    for column in range(3):
        mean = np.bincount(inverse.ravel(), points.points[:, column]) / counts
        assert np.abs(voxels.means[:, column] - mean).max() < 1e-6 * 0.7
        colour = np.bincount(inverse.ravel(), points.colours[:, column]) / counts
        assert np.abs(voxels.colours[:, column] - colour).max() <= 0.5
    assert np.array_equal(voxels.centres, (index + 0.5) * 0.7)


def test_map_of_colourless_points_has_no_colours(tmp_path):
    coloured = random_cloud(np.random.default_rng(1), num=200, spread=2.0)
    plain = replace(coloured, colours=None)
    voxel_map = filled(plain)
    assert voxel_map.occupied(1).colours is None
    for lean in (False, True):
        voxel_map.save(tmp_path / "map.npz", lean=lean)
        assert VoxelMap.load(tmp_path / "map.npz").occupied(1).colours is None
    assert voxel_map.cropped([-1, -1, -1], [1, 1, 1]).occupied(1).colours is None
    with collected_notices() as notices:
        mixed = filled(coloured)
        assert mixed.occupied(1).colours is not None
        assert notices == []
        mixed.merge(voxel_map)
    assert mixed.occupied(1).colours is None
    assert [one.code for one in notices] == ["colour-missing"]
    # An empty first cloud says nothing about the colours of later ones.
    empty = filled(plain.select(slice(0)), coloured)
    assert np.array_equal(empty.occupied(1).colours, filled(coloured).occupied(1).colours)


def test_cell_below_zero_is_minus_one():
    voxels = filled(cloud([[-1e-20, -1.0, -1.0000001], [0.0, 0.999, 1.0]])).occupied(1)
    assert voxels.index.tolist() == [[-1, -1, -2], [0, 0, 1]]
    inside = voxels.means - voxels.index
    assert (inside > 0).all()
    assert (inside < 1).all()


def test_occupied_keeps_cells_with_enough_points():
    voxel_map = filled(cloud([[0.5, 0.5, 0.5]] * 5 + [[1.5, 0.5, 0.5]] * 4))
    assert voxel_map.num_cells == 2
    assert voxel_map.occupied().counts.tolist() == [5]
    assert voxel_map.occupied(min_count=4).counts.tolist() == [5, 4]
    assert len(voxel_map.occupied(min_count=6)) == 0


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1), chunks=st.integers(1, 7), cell=st.sampled_from([0.1, 1.0]))
def test_order_chunks_and_merging_do_not_change_a_bit(seed, chunks, cell, tmp_path_factory):
    rng = np.random.default_rng(seed)
    points = random_cloud(rng, num=500, spread=2.0)
    whole = filled(points, cell_size=cell)
    parts = np.array_split(rng.permutation(len(points)), chunks)
    chunked = filled(*(points.select(part) for part in parts), cell_size=cell)
    merged = VoxelMap(cell)
    for part in parts:
        merged.merge(filled(points.select(part), cell_size=cell))
    assert same(whole.occupied(1), chunked.occupied(1))
    assert same(whole.occupied(1), merged.occupied(1))
    folder = tmp_path_factory.mktemp("maps")
    for number, each in enumerate([whole, chunked, merged]):
        each.save(folder / f"{number}.npz")
    first, *others = [(folder / f"{n}.npz").read_bytes() for n in range(3)]
    assert all(other == first for other in others)


def test_cell_with_very_many_points_stays_exact():
    points = cloud([[0.25, 0.5, 0.75]] * 5000, [[255, 254, 1]] * 5000)
    voxels = filled(points, points).occupied()
    assert voxels.counts.tolist() == [10000]
    assert voxels.colours.tolist() == [[255, 254, 1]]
    assert np.abs(voxels.means - [0.25, 0.5, 0.75]).max() < 1e-6


def test_merging_a_map_with_itself_doubles_its_counts():
    voxel_map = filled(random_cloud(np.random.default_rng(3)))
    before = voxel_map.occupied(1)
    voxel_map.merge(voxel_map)
    after = voxel_map.occupied(1)
    assert np.array_equal(after.counts, 2 * before.counts)
    assert np.allclose(after.means, before.means, atol=1e-12)


def test_maps_with_different_cell_sizes_cannot_be_merged():
    with pytest.raises(InputError, match=r"cell_size is 0.5, but 1.0 is needed"):
        VoxelMap(1.0).merge(VoxelMap(0.5))


@pytest.mark.parametrize("far", [1e6, -1e6])
def test_positions_far_from_the_origin_stay_precise(far):
    rng = np.random.default_rng(5)
    near = rng.uniform(0, 0.1, (50, 3))
    voxels = filled(cloud(near + far), cell_size=0.1).occupied(1)
    cells = np.floor((near + far) / 0.1)
    assert np.array_equal(voxels.index, np.unique(cells, axis=0))
    for index, mean in zip(voxels.index, voxels.means, strict=True):
        inside = (near + far)[(cells == index).all(axis=1)].mean(axis=0)
        assert np.abs(mean - inside).max() < 1e-3 * 0.1


@pytest.mark.parametrize("value", [np.nan, np.inf, -1e10])
def test_points_out_of_range_are_rejected_and_change_nothing(value):
    voxel_map = filled(cloud([[0, 0, 0]]))
    with pytest.raises(InputError, match="finite numbers within"):
        voxel_map.insert(cloud([[1, 1, 1], [0, value, 0]]))
    assert voxel_map.num_cells == 1


@pytest.mark.parametrize("cell_size", [0, -1, np.nan, np.inf])
def test_invalid_cell_size_is_rejected(cell_size):
    with pytest.raises(InputError, match="cell_size is"):
        VoxelMap(cell_size)


@pytest.mark.parametrize("ray_margin", [-1, np.nan, np.inf])
def test_invalid_ray_margin_is_rejected(ray_margin):
    with pytest.raises(InputError, match="ray_margin is"):
        VoxelMap(ray_margin=ray_margin)


def test_empty_map_has_no_cells(tmp_path):
    voxel_map = filled(cloud([]))
    assert voxel_map.num_cells == 0
    assert len(voxel_map.occupied(1)) == 0
    voxel_map.save(tmp_path / "map.npz")
    assert VoxelMap.load(tmp_path / "map.npz").num_cells == 0


def test_save_and_load_are_exact(tmp_path):
    voxel_map = filled(random_cloud(np.random.default_rng(7)), cell_size=0.3)
    voxel_map.save(tmp_path / "map.npz")
    loaded = VoxelMap.load(tmp_path / "map.npz")
    assert loaded.cell_size == 0.3
    assert same(loaded.occupied(1), voxel_map.occupied(1))


@settings(max_examples=40)
@given(
    place=st.tuples(*[st.floats(-1e6, 1e6)] * 3),
    cell_size=st.sampled_from([0.1, 0.3, 1.0, 7.5]),
)
def test_any_point_lies_in_its_cell_and_keeps_its_position(place, cell_size):
    voxels = filled(cloud([place]), cell_size=cell_size).occupied(1)
    index = np.floor(np.array(place) / cell_size)
    assert voxels.index.tolist() == [index.astype(int).tolist()]
    assert np.abs(voxels.means - place).max() <= 1e-3 * cell_size


def test_memory_depends_on_the_map_and_not_on_the_number_of_points():
    voxel_map = VoxelMap(0.5)
    points = random_cloud(np.random.default_rng(9), num=20_000, spread=3.0)
    sizes = []
    for _ in range(30):
        voxel_map.insert(points)
        sizes.append(voxel_map.nbytes)
    assert sizes[0] / voxel_map.num_cells < 80
    assert sizes[-1] <= 2 * sizes[0]
