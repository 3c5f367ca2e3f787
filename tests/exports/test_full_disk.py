"""A full disk is reported, and leaves what was there."""

import resource
from contextlib import contextmanager

import pytest

from recon.errors import ReconError
from recon.exports import read, write
from tests.exports.maps import sample_map

WRITABLE_FORMATS = [".ply", ".npz", ".parquet", ".las", ".csv", ".ot", ".vti", ".glb"]


@contextmanager
def full_disk():
    """A limit on file sizes stands in for a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1024, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("ending", WRITABLE_FORMATS)
def test_full_disk_is_reported_and_keeps_the_existing_file(tmp_path, ending):
    """VTK and OctoMap report neither."""
    path = tmp_path / f"map{ending}"
    voxels = sample_map(()).occupied(1)
    write(voxels, path)  # compiles and caches the kernels without the limit
    path.write_bytes(b"before")
    with full_disk(), pytest.raises((ReconError, OSError)) as error:
        write(voxels, path)
    assert f"map{ending}" in str(error.value)
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]


def test_full_disk_keeps_the_existing_zarr_group(tmp_path):
    path = tmp_path / "map.zarr"
    voxels = sample_map(()).occupied(1)
    write(voxels, path)
    with full_disk(), pytest.raises(OSError, match=r"map\.zarr"):
        write(voxels, path)
    assert len(read(path)) == len(voxels)
    assert list(tmp_path.iterdir()) == [path]
