"""The map's file: exact, reproducible, and rejected in one line if it is damaged."""

import io
import zipfile

import numpy as np
import pytest

from recon.errors import InputError
from recon.voxelmap import VoxelMap
from tests.voxelmap.clouds import cloud, filled, observed, random_cloud, random_scans, saved_bytes


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "map.npz"
    observed(random_scans(1)).save(path)
    return path


def with_columns(path, **columns):
    """Rewrite the file with some arrays replaced."""
    content = dict(np.load(path)) | columns
    np.savez_compressed(path, **content)
    return path


def assert_rejected(path, message):
    with pytest.raises(InputError, match=message) as error:
        VoxelMap.load(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_plain_numpy_reads_the_columns(path):
    with np.load(path, allow_pickle=False) as columns:
        index = np.cumsum(columns["index"], axis=1, dtype=np.uint32).view(np.int32).T
        voxels = VoxelMap.load(path).occupied(1)
        assert np.array_equal(index, voxels.index)
        assert np.array_equal(columns["count"], voxels.counts)


@pytest.mark.parametrize("index", [[0, 0, 0], [2**31 - 3, -(2**31) + 2, 5]])
def test_cells_at_the_limits_of_the_grid_round_trip(tmp_path, index):
    voxel_map = filled(cloud([np.add(index, 0.5), [0.5, 0.5, 0.5], np.add(index, 1.5)]))
    voxel_map.save(tmp_path / "map.npz")
    loaded = VoxelMap.load(tmp_path / "map.npz").occupied(1)
    assert np.array_equal(loaded.index, voxel_map.occupied(1).index)


def test_map_with_large_sums_round_trips(tmp_path):
    voxel_map = filled(cloud([[0.5, 0.5, 0.5]] * 9000, [[255, 254, 253]] * 9000))
    whole = saved_bytes(voxel_map, tmp_path)
    assert saved_bytes(VoxelMap.load(tmp_path / "map.npz"), tmp_path) == whole


def test_lean_file_keeps_index_count_and_mean_colour(tmp_path):
    voxel_map = filled(random_cloud(np.random.default_rng(3)))
    exact = len(saved_bytes(voxel_map, tmp_path))
    lean = len(saved_bytes(voxel_map, tmp_path, lean=True))
    before, after = voxel_map.occupied(1), VoxelMap.load(tmp_path / "map.npz").occupied(1)
    assert lean < 0.5 * exact
    for name in ("index", "counts", "colours"):
        assert np.array_equal(getattr(before, name), getattr(after, name))
    assert np.abs(after.means - after.centres).max() < 1e-6


def test_truncated_file_is_rejected(path):
    whole = path.read_bytes()
    for length in (0, 10, 500, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        assert_rejected(path, "not a whole npz archive")


def loaded_or_none(path):
    try:
        return VoxelMap.load(path).occupied(1)
    except InputError:
        return None


def test_corrupted_byte_is_rejected_or_harmless(path):
    whole = path.read_bytes()
    before = loaded_or_none(path)
    outcomes = []
    for place in np.random.default_rng(5).integers(0, len(whole), 40):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x55]) + whole[place + 1 :])
        outcomes.append(loaded_or_none(path))
    assert outcomes.count(None) > 30
    assert all(np.array_equal(each.means, before.means) for each in outcomes if each is not None)


def test_other_version_is_rejected(path):
    assert_rejected(with_columns(path, version=np.array(2)), "version 2, but 1 is needed")


def test_missing_column_is_rejected(path):
    content = dict(np.load(path))
    del content["count"]
    np.savez_compressed(path, **content)
    assert_rejected(path, "not a voxel map .*count")


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("cell_size", np.array(-1.0), "cell_size is -1.0"),
        ("channels", np.array(["pickle"]), "channel is 'pickle'"),
        ("view_cell", np.array([10**6]), "view_cell"),
        ("version", np.array("one"), "not a voxel map"),
        ("count", np.zeros(4, np.uint32), "not a voxel map"),
    ],
)
def test_inconsistent_columns_are_rejected(path, column, value, message):
    assert_rejected(with_columns(path, **{column: value}), message)


def test_impossible_sums_are_rejected(path):
    content = dict(np.load(path))
    assert_rejected(
        with_columns(path, position=content["position"] + 2**30), "cannot come from points"
    )
    assert_rejected(
        with_columns(path, **content | {"count": 0 * content["count"]}), "cannot come from points"
    )


def test_false_array_size_allocates_no_memory(tmp_path, path):
    """An array header claims 8 TB in an otherwise intact archive."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<u4", "fortran_order": False, "shape": (2 * 10**12,)}
    )
    with zipfile.ZipFile(path) as whole, zipfile.ZipFile(tmp_path / "liar.npz", "w") as liar:
        for name in whole.namelist():
            data = header.getvalue() + b"\0" * 100 if name == "count.npy" else whole.read(name)
            liar.writestr(name, data)
    assert_rejected(tmp_path / "liar.npz", "count.npy claims 8000000000000 bytes, but holds 100")


def test_objects_are_never_unpickled(tmp_path):
    np.savez(tmp_path / "evil.npz", version=np.array([print], dtype=object))
    assert_rejected(tmp_path / "evil.npz", "not contain plain numbers")


def test_file_that_is_not_an_archive_is_rejected(tmp_path):
    path = tmp_path / "map.npz"
    path.write_bytes(b"\x93NUMPY" + b"\0" * 100)
    assert_rejected(path, "not a whole npz archive")


def test_missing_file_raises_file_not_found(tmp_path):
    with pytest.raises(FileNotFoundError):
        VoxelMap.load(tmp_path / "none.npz")
