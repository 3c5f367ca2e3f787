"""Ordered sums: a map round-trips, and sums are added in any order, to the last bit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.errors import InputError
from recon.voxelmap import VoxelMap
from recon.voxelmap.summed import map_of, sums_of
from recon.voxelmap.sums import added, is_ordered, split
from tests.exports.maps import CHANNELS, sample_cloud

ORIGIN = [100.0, 2.0, -41.0]


def map_of_views(views, channels=CHANNELS):
    voxel_map = VoxelMap(0.5, channels=channels, ray_margin=1.5)
    for view in views:
        cloud = sample_cloud(view, num=80)
        voxel_map.insert(cloud, ORIGIN, view)
        voxel_map.insert_doubtful(cloud)
    return voxel_map


def saved(voxel_map, folder):
    voxel_map.save(folder / "map.npz")
    return (folder / "map.npz").read_bytes()


def rebuilt(cells, like):
    return map_of(cells, like.cell_size, like.channels, like.ray_margin)


@pytest.mark.parametrize("channels", [(), ("views",), ("rays", "weight"), CHANNELS])
def test_sums_round_trip_exactly(channels, tmp_path):
    whole = map_of_views(range(3), channels)
    assert whole.coarse
    assert saved(rebuilt(sums_of(whole), whole), tmp_path) == saved(whole, tmp_path)


@settings(max_examples=15)
@given(st.permutations(range(5)), st.sets(st.integers(1, 4)))
def test_parts_add_up_to_the_whole_in_any_order(order, cuts):
    chunks = [part for part in np.split(np.array(order), sorted(cuts)) if len(part)]
    total = added(sums_of(map_of_views(chunk.tolist())) for chunk in chunks)
    whole = sums_of(map_of_views(range(5)))
    assert is_ordered(total.index)
    assert np.array_equal(total.index, whole.index)
    assert np.array_equal(total.views, whole.views)
    assert all(np.array_equal(total.sums[name], whole.sums[name]) for name in whole.sums)


def test_every_cell_and_its_views_are_in_exactly_one_cube():
    whole = sums_of(map_of_views(range(3)))
    parts = dict(split(whole, 64))
    assert len(parts) > 1
    assert list(parts) == sorted(parts)
    for key, part in parts.items():
        cubes = (part.index[1:].astype(np.int64) << part.index[0]) // 64
        assert (key == cubes.T).all()
        assert is_ordered(part.index)
    total = added(parts.values())
    assert np.array_equal(total.index, whole.index)
    assert np.array_equal(total.views, whole.views)


def test_empty_map_has_no_cubes():
    assert not list(split(sums_of(VoxelMap(1.0, channels=CHANNELS)), 64))


def test_view_of_a_missing_cell_is_rejected():
    whole = map_of_views(range(2))
    cells = sums_of(whole)
    cells.views[:3, 0] += 1000
    with pytest.raises(InputError, match="without a point"):
        rebuilt(cells, whole)
