"""Partitioned maps: the same cells as in a single file, however they were written."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from recon.errors import InputError
from recon.exports.partitions.manifest import MANIFEST
from recon.exports.partitions.partitioned import PartitionedMap
from recon.exports.partitions.writing import merge_partitions, write_partitions
from recon.files import memory_limit
from recon.notices import collected_notices
from recon.voxelmap import VoxelMap
from tests.exports.maps import CHANNELS, same, sample_cloud
from tests.recordings import contents
from tests.voxelmap.test_sums import ORIGIN, map_of_views, saved

BOX = ((98.0, -1.0, -45.0), (104.0, 5.0, -38.0))


@pytest.fixture(scope="module")
def whole():
    return map_of_views(range(6))


@pytest.fixture(scope="module")
def city(whole, tmp_path_factory):
    return write_partitions(whole, tmp_path_factory.mktemp("city") / "map.parquet", 64)


def test_partitioned_map_equals_the_map(whole, city, tmp_path):
    assert len(city) > 1
    assert (city.num_cells, city.channels) == (whole.num_cells, whole.channels)
    assert saved(city.whole(), tmp_path) == saved(whole, tmp_path)
    same(city.occupied(2), whole.occupied(2))
    assert sum(one.num_cells for one in city) == whole.num_cells
    same(city.sightings(), whole.sightings())


@pytest.mark.parametrize("cuts", [[3], [1, 2], [1, 2, 3, 4, 5]])
def test_any_chunks_merge_to_the_same_bytes(city, cuts, tmp_path):
    chunks = np.split(np.arange(6), cuts)
    parts = [
        write_partitions(map_of_views(chunk.tolist()), tmp_path / f"{n}.parquet", 64)
        for n, chunk in enumerate(chunks)
    ]
    merged = merge_partitions(parts[::-1], tmp_path / "all.parquet")
    assert contents(merged.place) == contents(city.place)


def test_box_reads_only_intersecting_partitions(whole, city, tmp_path):
    copy = tmp_path / "map.parquet"
    shutil.copytree(city.place, copy)
    met = {entry.file for entry in city.intersecting(BOX)}
    assert 0 < len(met) < len(city)
    for entry in city.partitions:
        if entry.file not in met:
            (copy / entry.file).unlink()
    part = PartitionedMap(copy)
    same(part.occupied(1, box=BOX), whole.cropped(*BOX).occupied(1))
    assert saved(part.within(BOX), tmp_path) == saved(whole.cropped(*BOX), tmp_path)
    with pytest.raises(InputError, match="is missing"):
        part.whole()


def test_views_of_different_recordings_stay_distinct(tmp_path):
    one = write_partitions(map_of_views([0], ("views",)), tmp_path / "one.parquet", 64)
    both = [one, one]
    alike = merge_partitions(both, tmp_path / "alike.parquet").occupied(2)
    apart = merge_partitions(both, tmp_path / "apart.parquet", [0, 7]).occupied(2)
    assert set(alike.num_views) == {1}
    assert set(apart.num_views) == {2}


def test_cells_beyond_the_limit_are_coarsened(whole, city):
    fine = whole.occupied(1)
    fitting = city.fitting(lambda one: one.occupied(1), len(fine) // 3)
    found = fitting.voxels
    assert fitting.factor > 1
    assert fitting.num_chosen == len(fine)
    assert len(found) <= len(fine) // 3
    assert found.counts.sum() == fine.counts.sum()
    assert (found.means // found.cell_size == found.index).all()
    centre = np.average(fine.means, axis=0, weights=fine.counts)
    assert np.allclose(np.average(found.means, axis=0, weights=found.counts), centre)
    as_they_are = city.fitting(lambda one: one.occupied(1), len(fine))
    assert as_they_are.factor == 1
    same(as_they_are.voxels, fine)


def test_too_large_selection_is_rejected(city):
    with memory_limit(1000), pytest.raises(InputError, match="of memory"):
        city.whole()


def test_map_on_another_file_system(whole, tmp_path):
    pytest.importorskip("fsspec")
    there = write_partitions(whole, "memory://town/map.parquet", 64)
    assert saved(there.whole(), tmp_path) == saved(whole, tmp_path)
    with pytest.raises(InputError, match="not a whole partitioned map"):
        PartitionedMap("memory://elsewhere/map.parquet")
    with pytest.raises(InputError, match="nowhere"):
        PartitionedMap("nowhere://elsewhere/map.parquet")


def test_smaller_map_replaces_all_earlier_partitions(city, tmp_path):
    copy = tmp_path / "map.parquet"
    shutil.copytree(city.place, copy)
    small = write_partitions(map_of_views([]), copy, 64)
    assert set(contents(copy)) == {MANIFEST}
    assert len(small) == 0
    assert small.whole().num_cells == len(small.occupied(1)) == 0


def changed(document, **values):
    return json.dumps(document | values)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"version": 9}, "version 9"),
        ({"cell_size": 0}, "cell_size"),
        ({"partition_size": 65}, "multiple of 64"),
        ({"partition_size": "x"}, "partition_size"),
        ({"channels": ["views", "views"]}, "channels"),
        ({"partitions": [{"index": [0, 0]}]}, "damaged"),
        ({"partitions": None}, "damaged"),
    ],
)
def test_invalid_manifest_is_rejected(city, values, said, tmp_path):
    copy = tmp_path / "map.parquet"
    shutil.copytree(city.place, copy)
    document = json.loads((copy / MANIFEST).read_text())
    (copy / MANIFEST).write_text(changed(document, **values))
    with pytest.raises(InputError, match=said):
        PartitionedMap(copy)


def test_misplaced_partition_is_rejected(city, tmp_path):
    copy = tmp_path / "map.parquet"
    shutil.copytree(city.place, copy)
    first, second = city.partitions[:2]
    shutil.copy(copy / first.file, copy / second.file)
    with pytest.raises(InputError, match="not the one of its manifest"):
        PartitionedMap(copy).occupied(1)


def test_incompatible_maps_cannot_be_added(city, tmp_path):
    other = write_partitions(map_of_views(range(2), ()), tmp_path / "other.parquet", 64)
    with pytest.raises(InputError, match="channels"):
        merge_partitions([city, other], tmp_path / "both.parquet")


def colourless(views):
    """Make a map of clouds without colours."""
    voxel_map = VoxelMap(0.5, channels=CHANNELS, ray_margin=1.5)
    for view in views:
        cloud = replace(sample_cloud(view, num=80), colours=None)
        voxel_map.insert(cloud, ORIGIN, view)
        voxel_map.insert_doubtful(cloud)
    return voxel_map


def test_colourless_map_stays_colourless_in_partitions_and_sums(tmp_path):
    with collected_notices() as notices:
        grey = write_partitions(colourless([0, 1]), tmp_path / "grey.parquet", 64)
    assert notices == []
    assert grey.occupied(1).colours is None
    assert saved(grey.whole(), tmp_path) == saved(colourless([0, 1]), tmp_path)
    coloured = write_partitions(map_of_views([2, 3]), tmp_path / "coloured.parquet", 64)
    with collected_notices() as notices:
        merged = merge_partitions([coloured, grey], tmp_path / "all.parquet")
    assert [notice.code for notice in notices] == ["colour-missing"]
    assert merged.occupied(1).colours is None
    assert saved(merged.whole(), tmp_path) == saved(colourless(range(4)), tmp_path)


def test_older_partitions_have_colours(city, tmp_path):
    copy = tmp_path / "map.parquet"
    shutil.copytree(city.place, copy)
    manifest = json.loads((copy / MANIFEST).read_text())
    del manifest["has_colour"]
    (copy / MANIFEST).write_text(json.dumps(manifest))
    same(PartitionedMap(copy).occupied(1), city.occupied(1))
