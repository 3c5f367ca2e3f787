"""Files that cannot be read, and data that a format cannot hold, are rejected in one line."""

import re
import sys

import numpy as np
import pytest

from recon.errors import InputError, MissingLibraryError
from recon.exports import FORMATS, read, write
from recon.records import PointCloud
from recon.voxelmap import VoxelMap
from tests.exports.maps import CELL_FORMATS, GRID_FORMATS, sample_cloud, sample_map


@pytest.mark.parametrize("ending", [".foo", "", ".docx"])
def test_unknown_extension_is_rejected(tmp_path, ending):
    with pytest.raises(InputError, match=r"is unknown; known are \.ply \.pcd \.las"):
        write(sample_cloud(), tmp_path / f"cloud{ending}")
    with pytest.raises(FileNotFoundError):  # a missing file is reported before its format
        read(tmp_path / f"cloud{ending}")
    (tmp_path / f"cloud{ending}").write_text("0 0 0\n")
    with pytest.raises(InputError, match="is unknown; known are"):
        read(tmp_path / f"cloud{ending}")


@pytest.mark.parametrize("ending", [".vti", ".bt", ".pgm"])
def test_formats_for_cells_reject_points(tmp_path, ending):
    with pytest.raises(InputError, match="a format for cells cannot hold a cloud of points"):
        write(sample_cloud(), tmp_path / f"cloud{ending}")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", FORMATS.names())
def test_missing_file_raises_file_not_found(tmp_path, ending):
    with pytest.raises(FileNotFoundError):
        read(tmp_path / f"map{ending}")


@pytest.mark.parametrize("ending", FORMATS.names())
@pytest.mark.parametrize("content", [b"", b"\x00\x01 nonsense \xff" * 40])
def test_invalid_content_is_rejected_in_one_line(tmp_path, ending, content, capfd):
    path = tmp_path / f"map{ending}"
    path.write_bytes(content)
    with pytest.raises(InputError) as error:
        read(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "ending", [e for e in (*CELL_FORMATS, *GRID_FORMATS) if e not in (".zarr", ".pgm")]
)
@pytest.mark.parametrize("share", [0.3, 0.95])
def test_truncated_file_is_rejected_in_one_line(tmp_path, ending, share, capfd):
    path = tmp_path / f"map{ending}"
    write(sample_map(()), path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InputError) as error:
        read(path)
    assert str(error.value).count(str(path)) == 1
    assert "\n" not in str(error.value)
    assert capfd.readouterr() == ("", "")


def test_grid_that_claims_too_many_cells_is_rejected(tmp_path):
    write(sample_map(()), tmp_path / "map.vti")
    content = (tmp_path / "map.vti").read_bytes()
    start = content.index(b'WholeExtent="') + len(b'WholeExtent="')
    end = content.index(b'"', start)
    lie = content[:start] + b"0 100000 0 100000 0 100000" + content[end:]
    (tmp_path / "map.vti").write_bytes(lie)
    with pytest.raises(InputError, match="claims 1000000000000000 cells, but"):
        read(tmp_path / "map.vti")


@pytest.mark.parametrize(
    ("ending", "module", "extra"),
    [
        (".las", "laspy", "las"),
        (".bt", "pyoctomap", "octomap"),
        (".glb", "trimesh", "mesh"),
        (".zarr", "zarr", "tables"),
        (".parquet", "pyarrow.parquet", "tables"),
    ],
)
def test_missing_library_is_named_with_its_extra(tmp_path, monkeypatch, ending, module, extra):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingLibraryError, match=rf"pip install 'recon-stereo\[{extra}\]'"):
        write(sample_map(()), tmp_path / f"map{ending}")
    assert list(tmp_path.iterdir()) == []


def test_cells_out_of_range_for_octomap_are_rejected(tmp_path):
    voxel_map = VoxelMap(1.0)
    far = PointCloud(points=np.array([[0, 40000.0, 0]]), colours=np.zeros((1, 3), np.uint8))
    voxel_map.insert(far)
    with pytest.raises(InputError, match="40000 cells from the origin, but OctoMap's trees reach"):
        write(voxel_map, tmp_path / "map.ot")


def test_too_large_grid_is_rejected(tmp_path):
    voxel_map = VoxelMap(1.0)
    ends = PointCloud(points=np.array([[-1e4] * 3, [1e4] * 3]), colours=np.zeros((2, 3), np.uint8))
    voxel_map.insert(ends)
    with pytest.raises(InputError, match="the cells span 20001 x 20001 x 20001, but"):
        write(voxel_map, tmp_path / "map.vti")


def test_ply_without_coordinates_is_rejected(tmp_path):
    (tmp_path / "cloud.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"
    )
    with pytest.raises(InputError, match=r"cloud\.ply: its columns are x, but y is needed"):
        read(tmp_path / "cloud.ply")


def test_grid_out_of_range_is_rejected_and_unknown_arrays_are_ignored(tmp_path):
    path = tmp_path / "map.vti"
    write(sample_map(()), path)
    content = path.read_bytes()
    path.write_bytes(content.replace(b'Name="colours"', b'Name="cOlours"'))
    assert read(path).colours is None
    path.write_bytes(re.sub(rb'Origin="[^ ]+', b'Origin="1e20', content))
    with pytest.raises(InputError, match="out of reach"):
        read(path)
