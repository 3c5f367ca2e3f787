"""Channels of a map: correct values, independent of order, chunks and merging."""

import dataclasses
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.errors import InputError
from recon.voxelmap import VoxelMap
from tests.voxelmap.clouds import ALL_CHANNELS, cloud, observed, random_scans, saved_bytes


@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1), margin=st.sampled_from([0.0, 1.5]))
def test_order_and_merging_do_not_change_a_bit(seed, margin, tmp_path_factory):
    folder = tmp_path_factory.mktemp("maps")
    scans = random_scans(seed)
    whole = saved_bytes(observed(scans, ray_margin=margin), folder)
    assert saved_bytes(observed(scans[::-1], ray_margin=margin), folder) == whole
    merged = observed(scans[:2], ray_margin=margin)
    merged.merge(observed(scans[2:], ray_margin=margin))
    assert saved_bytes(merged, folder) == whole
    assert saved_bytes(VoxelMap.load(folder / "map.npz"), folder) == whole


def test_splitting_a_view_into_chunks_does_not_change_its_channels(tmp_path):
    channels = ("weight", "views")
    scans = random_scans(1)
    chunks = [
        (points.select(part), origin, view)
        for points, origin, view in scans
        for part in np.array_split(np.arange(len(points)), 4)
    ]
    whole = saved_bytes(observed(scans, channels=channels), tmp_path)
    assert saved_bytes(observed(chunks, channels=channels), tmp_path) == whole


def test_unpickled_map_can_be_extended(tmp_path):
    scans = random_scans(4)
    half = pickle.loads(pickle.dumps(observed(scans[:2])))
    for points, origin, view in scans[2:]:
        half.insert(points, origin, view)
    assert saved_bytes(half, tmp_path) == saved_bytes(observed(scans), tmp_path)


def test_single_precision_points_are_accepted(tmp_path):
    [(points, origin, view)] = random_scans(6, num_scans=1)
    single = points.points.astype(np.float32)
    maps = [
        observed([(dataclasses.replace(points, points=single.astype(kind)), origin, view)])
        for kind in (np.float32, np.float64)
    ]
    assert saved_bytes(maps[0], tmp_path) == saved_bytes(maps[1], tmp_path)


def test_merging_a_map_with_itself_doubles_sums_but_not_views():
    voxel_map = observed(random_scans(2))
    before = voxel_map.occupied(1)
    voxel_map.merge(voxel_map)
    after = voxel_map.occupied(1)
    for name in ("counts", "hits", "passes", "weights"):
        assert np.array_equal(getattr(after, name), 2 * getattr(before, name)), name
    assert np.array_equal(after.num_views, before.num_views)


def test_weights_decrease_with_sigma():
    sigma = np.array([0.0, 0.15, 0.3, 1.5])
    points = cloud([[0.1, 0.1, 0.1], [0.6, 0, 0], [1.1, 0, 0], [1.6, 0, 0]], sigma=sigma)
    voxels = observed([(points, None, None)], cell_size=0.5, channels=["weight"]).occupied(1)
    # The weight is one half at a sigma of 0.3 cells.
    assert np.abs(voxels.weights - [1.0, 0.5, 0.2, 1 / 101]).max() < 1e-6


def test_each_view_is_counted_once():
    here, there = cloud([[0, 0, 0]] * 3), cloud([[5, 0, 0]])
    scans = [(here, None, 7), (here, None, 7), (there, None, 7), (here, None, 2**31 - 1)]
    assert observed(scans, channels=["views"]).occupied(1).num_views.tolist() == [2, 1]


def test_memory_stays_bounded_for_many_chunks_of_one_view():
    voxel_map = VoxelMap(channels=["views"])
    points = cloud(np.random.default_rng(3).uniform(0, 30, (5000, 3)))
    for _ in range(40):
        voxel_map.insert(points, view=1)
    sets = voxel_map._channels["views"]
    assert len(sets._pairs) + sets._num_new < 4 * voxel_map.num_cells + (1 << 17)
    assert (voxel_map.occupied(1).num_views == 1).all()


@pytest.mark.parametrize(
    ("channel", "message"),
    [
        ("weight", "no sigma, but a map that keeps weights needs it"),
        ("views", "view is None, but a map that keeps views needs its number"),
        ("rays", "origin is None, but a map that keeps rays needs"),
    ],
)
def test_missing_input_of_a_channel_is_rejected_before_the_map_changes(channel, message):
    voxel_map = VoxelMap(channels=[channel])
    with pytest.raises(InputError, match=message):
        voxel_map.insert(cloud([[0, 0, 0]]))
    assert voxel_map.num_cells == 0


def test_unknown_channel_is_rejected():
    with pytest.raises(InputError, match="channel is 'colour', but one of weight, views"):
        VoxelMap(channels=["colour"])


def test_maps_with_different_channels_cannot_be_merged():
    with pytest.raises(InputError, match="the other map's channels is"):
        VoxelMap(channels=ALL_CHANNELS).merge(VoxelMap())
