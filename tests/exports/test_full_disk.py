"""A full disk is reported, and leaves what was there."""

import resource

import pytest

from recon.errors import ReconError
from recon.exports import write
from tests.exports.maps import sample_map

WRITABLE_FORMATS = [".ply", ".npz", ".parquet", ".las", ".csv", ".ot", ".vti", ".glb"]


@pytest.mark.parametrize("ending", WRITABLE_FORMATS)
def test_full_disk_is_reported_and_keeps_the_existing_file(tmp_path, ending):
    """A limit on file sizes stands in for a full disk; VTK and OctoMap report neither."""
    path = tmp_path / f"map{ending}"
    voxels = sample_map(()).occupied(1)
    write(voxels, path)  # compiles and caches the kernels without the limit
    path.write_bytes(b"before")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1024, hard))
    try:
        with pytest.raises((ReconError, OSError), match=r"map\.") as error:
            write(voxels, path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert f"map{ending}" in str(error.value)
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]
