"""`recon learn` refuses examples and catalogues that it cannot use, and changes nothing."""

import numpy as np
import pytest

from recon.cli import main
from recon.exports import write
from recon.records import PointCloud


@pytest.fixture
def ball(tmp_path):
    """A sphere of 2,000 points."""
    points = np.random.default_rng(0).normal(size=(2000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    write(PointCloud(points=points), tmp_path / "ball.ply")
    return tmp_path / "ball.ply"


def learned(example, catalogue, name="ball"):
    return main(["learn", str(example), "--name", name, "-o", str(catalogue), "-q"])


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.full((9, 3), np.nan)])
def test_example_without_points_is_refused(tmp_path, capsys, points):
    write(PointCloud(points=points), tmp_path / "empty.ply")
    assert learned(tmp_path / "empty.ply", tmp_path / "kinds.toml") == 2
    assert "empty.ply has no points, but 30 cells are needed" in capsys.readouterr().err
    assert not (tmp_path / "kinds.toml").exists()


@pytest.mark.parametrize("content", [b"[map\n", b"\x89PNG\r\n", b"", b"object = 3\n"])
def test_file_that_is_no_catalogue_is_refused_and_kept(ball, tmp_path, capsys, content):
    (tmp_path / "kinds.toml").write_bytes(content)
    assert learned(ball, tmp_path / "kinds.toml") == 2
    assert capsys.readouterr().err.startswith(f"recon: {tmp_path / 'kinds.toml'}:")
    assert (tmp_path / "kinds.toml").read_bytes() == content


def test_unknown_is_no_name(ball, tmp_path, capsys):
    assert learned(ball, tmp_path / "kinds.toml", "unknown") == 2
    assert (
        "name is 'unknown', but one line other than 'unknown' is needed" in capsys.readouterr().err
    )


def test_example_given_twice_is_refused(ball, tmp_path, capsys):
    argv = ["learn", str(ball), str(ball), "--name", "ball", "-o", str(tmp_path / "kinds.toml")]
    assert main(argv) == 2
    assert "ball.ply is given 2 times, but must count once" in capsys.readouterr().err


def test_kinds_are_added_to_a_catalogue(ball, tmp_path, capsys):
    for name in ("ball", "ball"):
        assert learned(ball, tmp_path / "kinds.toml", name) == 0
    assert main(["catalogue", "check", str(tmp_path / "kinds.toml")]) == 0
    assert capsys.readouterr().out.count("ball\n") == 1
