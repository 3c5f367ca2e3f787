"""Points as PLY: written completely or not at all, read back, read by Open3D."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.exports.ply import CloudWriter, read_cloud_chunks
from recon.libraries import load_open3d
from recon.records import PointCloud


def random_cloud(seed, num=100):
    rng = np.random.default_rng(seed)
    return PointCloud(
        points=rng.normal(scale=1e3, size=(num, 3)),
        colours=rng.integers(0, 256, (num, 3)).astype(np.uint8),
        sigma=rng.random(num),
    )


def written(path, clouds):
    with CloudWriter(path) as writer:
        for number, cloud in enumerate(clouds):
            writer.append(cloud, number)
    return path


def test_cloud_of_a_run_round_trips_exactly(tmp_path):
    clouds = [random_cloud(seed, num) for seed, num in enumerate((100, 0, 7))]
    path = written(tmp_path / "cloud.ply", clouds)
    [(cloud, pair_number)] = read_cloud_chunks(path)
    assert np.array_equal(cloud.points, np.concatenate([each.points for each in clouds]))
    assert np.array_equal(cloud.colours, np.concatenate([each.colours for each in clouds]))
    assert np.array_equal(cloud.sigma, np.concatenate([each.sigma for each in clouds]))
    assert np.array_equal(pair_number, np.repeat([0, 1, 2], [100, 0, 7]))


def test_same_points_give_the_same_bytes(tmp_path):
    first, second = (written(tmp_path / f"{n}.ply", [random_cloud(1)]) for n in range(2))
    assert first.read_bytes() == second.read_bytes()


def test_open3d_reads_it_with_every_value(tmp_path):
    cloud = random_cloud(2)
    path = written(tmp_path / "cloud.ply", [cloud])
    read = load_open3d().t.io.read_point_cloud(str(path))
    assert np.array_equal(read.point["positions"].numpy(), cloud.points)
    assert np.array_equal(read.point["colors"].numpy(), cloud.colours)
    assert np.array_equal(read.point["sigma"].numpy().ravel(), cloud.sigma)
    assert read.point["pair"].numpy().max() == 0


def test_unfinished_cloud_leaves_no_file(tmp_path):
    def cut():
        with CloudWriter(tmp_path / "cloud.ply") as writer:
            writer.append(random_cloud(3), 0)
            raise RuntimeError("cut")

    with pytest.raises(RuntimeError, match="cut"):
        cut()
    assert list(tmp_path.iterdir()) == []


def test_truncated_file_is_rejected(tmp_path):
    path = written(tmp_path / "cloud.ply", [random_cloud(4)])
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(InputError, match="100 vertices are claimed, but"):
        list(read_cloud_chunks(path))


def test_file_that_is_not_ply_is_rejected(tmp_path):
    path = tmp_path / "cloud.ply"
    path.write_bytes(b"\x00" * 1000)
    with pytest.raises(InputError, match="not a PLY file"):
        list(read_cloud_chunks(path))
