"""Maps and clouds from files, through the command line: named, fitted, exported, described."""

import json

import numpy as np
import pytest

from recon.cli import main
from recon.exports.formats import read, write
from recon.records import PointCloud


def run_json(capsys, *argv):
    code = main([*map(str, argv), "--json"])
    out = capsys.readouterr().out
    return code, json.loads(out) if out else None


def as_cloud(points, rgb=(120, 60, 20)):
    colours = np.tile(np.array(rgb, np.uint8), (len(points), 1))
    return PointCloud(points=points, colours=colours)


@pytest.fixture
def ball(tmp_path):
    """A noisy sphere of radius 2 about (1, 2, 3)."""
    rng = np.random.default_rng(6)
    directions = rng.normal(size=(800, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    path = tmp_path / "ball.ply"
    write(as_cloud((1, 2, 3) + directions * rng.normal(2.0, 0.01, (800, 1))), path)
    return path


def test_a_ball_is_fitted(ball, capsys):
    code, report = run_json(capsys, "fit", ball)
    assert code == 0
    assert report["shape"] == "sphere"
    assert report["parameters"]["radius"] == pytest.approx(2.0, abs=0.01)
    np.testing.assert_allclose(report["parameters"]["centre"], [1, 2, 3], atol=0.01)
    assert 0.005 < report["rms"] < 0.02
    assert {"shape", "rms", "bic"} == set(report["candidates"][0])


def test_a_single_point_is_no_solid_in_one_line(tmp_path, capsys):
    write(as_cloud(np.zeros((1, 3))), tmp_path / "dot.ply")
    assert main(["fit", str(tmp_path / "dot.ply")]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "dot.ply" in error


def test_export_keeps_the_points_inside_the_box(ball, tmp_path, capsys):
    target = tmp_path / "half.pcd"
    code, report = run_json(capsys, "export", ball, target, "--box", "1,-9,-9,9,9,9")
    assert code == 0
    assert report["bytes"] == target.stat().st_size
    kept = read(target)
    assert 300 < len(kept) < 500
    assert kept.points[:, 0].min() >= 1
    assert main(["export", str(ball), str(target)]) == 2
    assert main(["export", str(ball), str(target), "--overwrite"]) == 0
    assert len(read(target)) == 800


@pytest.mark.parametrize("box", ["1,2,3", "0,0,0,-1,1,1", "a,b,c,d,e,f"])
def test_a_box_that_is_none_is_refused(ball, tmp_path, capsys, box):
    assert main(["export", str(ball), str(tmp_path / "x.pcd"), "--box", box]) == 2
    assert "--box" in capsys.readouterr().err


def test_an_ending_nobody_knows_is_named(ball, tmp_path, capsys):
    assert main(["export", str(ball), str(tmp_path / "ball.docx")]) == 2
    assert ".docx" in capsys.readouterr().err


def test_a_tree_is_named_and_the_catalogue_is_the_users(tmp_path, capsys):
    rng = np.random.default_rng(7)
    angle, height = rng.uniform(0, 2 * np.pi, 6000), rng.uniform(0, 8, 6000)
    trunk = np.column_stack([2 * np.cos(angle), height, 2 * np.sin(angle)])
    sphere = rng.normal(size=(9000, 3))
    crown = (0, 12, 0) + 4 * sphere / np.linalg.norm(sphere, axis=1, keepdims=True)
    path = tmp_path / "tree.ply"
    write(as_cloud(np.vstack([trunk, crown])), path)
    code, report = run_json(capsys, "recognise", path, "--catalogue", "village")
    assert code == 0
    (tree,) = report["objects"]
    assert tree["label"] == "apple tree"
    assert [part["role"] for part in tree["parts"]] == ["body", "crown"]
    catalogue = tmp_path / "mine.toml"
    catalogue.write_text(
        '[[object]]\nname = "lollipop"\nratio = [0.0, 0.9]\nparts = [\n'
        '  { role = "stick", shapes = ["cylinder"] },\n'
        '  { role = "sweet", shapes = ["sphere"] },\n]\n'
    )
    _, report = run_json(capsys, "recognise", path, "--catalogue", catalogue)
    assert report["objects"][0]["label"] == "lollipop"
