"""Maps and clouds from files, on the command line: named, fitted, exported, described."""

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


def test_ball_is_fitted(ball, capsys):
    code, report = run_json(capsys, "fit", ball)
    assert code == 0
    assert report["shape"] == "sphere"
    assert report["parameters"]["radius"] == pytest.approx(2.0, abs=0.01)
    np.testing.assert_allclose(report["parameters"]["centre"], [1, 2, 3], atol=0.01)
    assert 0.005 < report["rms"] < 0.02
    assert {"shape", "rms", "bic"} == set(report["candidates"][0])


def test_single_point_is_rejected_in_one_line(tmp_path, capsys):
    write(as_cloud(np.zeros((1, 3))), tmp_path / "dot.ply")
    assert main(["fit", str(tmp_path / "dot.ply")]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "dot.ply" in error


def test_export_keeps_the_points_inside_the_box(ball, tmp_path, capsys):
    target = tmp_path / "half.pcd"
    code, report = run_json(capsys, "export", ball, target, "--box", "1,-9,-9,9,9,9")
    assert report["num_points"] == len(read(target))
    assert code == 0
    assert report["bytes"] == target.stat().st_size
    kept = read(target)
    assert 300 < len(kept) < 500
    assert kept.points[:, 0].min() >= 1
    assert main(["export", str(ball), str(target)]) == 2
    assert main(["export", str(ball), str(target), "--overwrite"]) == 0
    assert len(read(target)) == 800


@pytest.mark.parametrize("box", ["1,2,3", "0,0,0,-1,1,1", "a,b,c,d,e,f"])
def test_invalid_box_is_rejected(ball, tmp_path, capsys, box):
    assert main(["export", str(ball), str(tmp_path / "x.pcd"), "--box", box]) == 2
    assert "--box" in capsys.readouterr().err


def test_unknown_extension_is_named(ball, tmp_path, capsys):
    assert main(["export", str(ball), str(tmp_path / "ball.docx")]) == 2
    assert ".docx" in capsys.readouterr().err


def test_tree_is_named_by_the_catalogue_of_the_user(tmp_path, capsys):
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


def test_cylinder_fit_reports_a_quarter_of_outliers(tmp_path, capsys):
    rng = np.random.default_rng(3)
    angle, height = rng.uniform(0, 2 * np.pi, 1540), rng.uniform(0, 8, 1540)
    rod = np.column_stack([2 * np.cos(angle), height, 2 * np.sin(angle)])
    rod += rng.normal(0, 0.01, rod.shape)
    blob = rng.uniform([2, 0, 2], [6, 8, 6], (460, 3))
    write(as_cloud(np.vstack([rod, blob])), tmp_path / "rod.ply")
    code, report = run_json(capsys, "fit", tmp_path / "rod.ply")
    assert code == 0
    assert report["shape"] == "cylinder"
    assert report["parameters"]["radius"] == pytest.approx(2.0, abs=0.01)
    assert report["explained"] == pytest.approx(0.77, abs=0.02)
    assert 0.008 < report["rms"] < 0.012
    assert [one["code"] for one in report["warnings"]] == ["points-unexplained"]


def test_good_fit_explains_all_points_without_a_warning(ball, capsys):
    _, report = run_json(capsys, "fit", ball)
    assert 0.98 < report["explained"] <= 1.0
    assert report["warnings"] == []


def test_empty_box_is_reported(ball, tmp_path, capsys):
    code, report = run_json(
        capsys, "export", ball, tmp_path / "none.ply", "--box", "50,50,50,51,51,51"
    )
    assert code == 0
    assert [one["code"] for one in report["warnings"]] == ["box-empty"]
    assert len(read(tmp_path / "none.ply")) == 0


@pytest.mark.parametrize(
    ("source", "target", "up", "turn", "codes"),
    [
        ("a.las", "b.ply", [], lambda p: p[:, [0, 2, 1]] * [1, 1, -1], ["turned-to-y-up"]),
        ("a.las", "b.ply", ["--up", "z"], lambda p: p, []),
        ("a.las", "b.las", [], lambda p: p, []),
        ("a.ply", "b.las", [], lambda p: p[:, [0, 2, 1]] * [1, -1, 1], []),
        ("a.ply", "b.las", ["--up", "y"], lambda p: p, []),
        ("a.ply", "b.ply", ["--up", "z"], lambda p: p[:, [0, 2, 1]] * [1, -1, 1], []),
    ],
)
def test_up_axis_can_be_chosen(tmp_path, capsys, source, target, up, turn, codes):
    points = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    # Files hold the points in their own axes, whatever is up.
    write(PointCloud(points=points), tmp_path / source, up="y" if source == "a.ply" else None)
    if source == "a.las":
        write(PointCloud(points=points), tmp_path / source, up="y")
    box = ["--box", "0,0,0,3,3,4"]
    code, report = run_json(capsys, "export", tmp_path / source, tmp_path / target, *up, *box)
    assert code == 0
    assert [one["code"] for one in report["warnings"]] == codes
    assert np.allclose(in_file_axes(tmp_path / target), turn(points)[:1])


def in_file_axes(path):
    """Read coordinates in the axes of the file."""
    if path.suffix == ".ply":
        return read(path).points
    laspy = pytest.importorskip("laspy")
    return laspy.read(path).xyz


def test_mesh_stays_a_mesh_unless_points_are_requested(tmp_path, capsys):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    code, report = run_json(capsys, "export", tmp_path / "a.obj", tmp_path / "b.ply")
    assert (code, report["num_triangles"]) == (0, 1)
    code, report = run_json(capsys, "export", tmp_path / "b.ply", tmp_path / "c.pcd")
    assert (code, report["num_points"]) == (0, 3)
    code, report = run_json(
        capsys, "export", tmp_path / "b.ply", tmp_path / "d.pcd", "--sample", "50"
    )
    assert (code, report["num_points"]) == (0, 50)


def test_columns_can_be_named_by_the_user(tmp_path, capsys):
    (tmp_path / "a.txt").write_text("1 2 3 4\n5 6 7 8\n")
    code, _ = run_json(
        capsys, "export", tmp_path / "a.txt", tmp_path / "b.ply", "--columns", "time,x,y,z"
    )
    assert code == 0
    assert read(tmp_path / "b.ply").points.tolist() == [[2, 3, 4], [6, 7, 8]]
    assert read(tmp_path / "b.ply").attributes["time"].tolist() == [1, 5]


def test_memory_can_be_limited_by_the_user(ball, tmp_path, capsys):
    argv = ["export", str(ball), str(tmp_path / "b.ply"), "--max-memory"]
    assert main([*argv, "1kB"]) == 2
    assert "give --max-memory" in capsys.readouterr().err
    assert main([*argv, "1GB"]) == 0
    assert main([*argv, "much"]) == 2
    assert main(["fit", str(ball), "-q"]) == 0
