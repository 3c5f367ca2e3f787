"""Files of other programs are read with all that they hold."""

import numpy as np
import pytest

from recon.exports import read, write
from recon.notices import collected_notices
from tests.exports.maps import CLOUD_FORMATS, sample_cloud


def test_foreign_text_ply_is_read(tmp_path):
    (tmp_path / "cloud.ply").write_text(
        "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 2\nproperty float x\n"
        "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
        "property uchar blue\nelement face 1\nproperty list uchar int vertex_indices\n"
        "end_header\n1 2 3 255 0 0\n4.5 5 6 0 255 0\n3 0 1 0\n"
    )
    cloud = read(tmp_path / "cloud.ply")
    assert cloud.points.tolist() == [[1, 2, 3], [4.5, 5, 6]]
    assert cloud.colours.tolist() == [[255, 0, 0], [0, 255, 0]]
    assert cloud.sigma is None


def test_big_endian_ply_without_colours_is_read(tmp_path):
    header = "ply\nformat binary_big_endian 1.0\nelement vertex 1\n"
    header += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    content = header.encode() + np.array([1.0, -2.0, 3.0], ">f8").tobytes()
    (tmp_path / "cloud.ply").write_bytes(content)
    cloud = read(tmp_path / "cloud.ply")
    assert cloud.points.tolist() == [[1, -2, 3]]
    assert cloud.colours is None


def test_foreign_npz_is_read(tmp_path):
    xyz = np.arange(6, dtype=np.float32).reshape(2, 3)
    np.savez(tmp_path / "cloud.npz", xyz=xyz, label=np.zeros(2, np.int16))
    assert read(tmp_path / "cloud.npz").points.tolist() == xyz.tolist()


def test_npz_in_fortran_order_is_read_without_nan_points(tmp_path):
    points = np.asfortranarray([[1.0, 2.0, 3.0], [np.nan, 0.0, 0.0], [4.0, 5.0, 6.0]])
    np.savez_compressed(tmp_path / "cloud.npz", points=points)
    assert read(tmp_path / "cloud.npz").points.tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize("ending", CLOUD_FORMATS[:2])
def test_nan_points_are_left_out_with_a_notice(tmp_path, ending):
    cloud = sample_cloud()
    cloud.points[7] = np.nan
    write(cloud, tmp_path / f"cloud{ending}")
    with collected_notices() as notices:
        assert len(read(tmp_path / f"cloud{ending}")) == len(cloud) - 1
    assert [notice.code for notice in notices] == ["points-left-out"]
    assert f"1 of {len(cloud)} points are not finite" in notices[0].text


@pytest.mark.data
def test_example_building_of_octomap_is_read(data_dir):
    voxels = read(data_dir / "octomap" / "geb079" / "geb079.bt")
    assert voxels.cell_size == 0.08
    assert len(voxels) == 185673
    # The bounds in OctoMap: x -8 to 30.96, y -7.52 to 7.44, and z, which becomes y here.
    low, high = voxels.index.min(axis=0) * 0.08, (voxels.index.max(axis=0) + 1) * 0.08
    assert -8.0 <= low[0] < high[0] <= 30.96 + 1e-9
    assert -0.32 - 1e-9 <= low[1] < high[1] <= 2.8 + 1e-9
    assert -7.44 - 1e-9 <= low[2] < high[2] <= 7.52 + 1e-9
    # One storey: the floor is the layer with most cells.
    layers = np.bincount(voxels.index[:, 1] - voxels.index[:, 1].min())
    assert abs((layers.argmax() + voxels.index[:, 1].min()) * 0.08) < 0.3
