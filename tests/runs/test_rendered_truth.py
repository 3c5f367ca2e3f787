"""Recordings with truth: rendered, reconstructed, and evaluated on the command line."""

import cv2
import numpy as np
import pytest

from recon.cli import main
from recon.exports import write
from recon.exports.ply import read_mesh, write_mesh
from recon.records import PointCloud
from recon.runs.reconstruct import unit_of
from recon.sequences.open import open_sequence
from recon.sequences.pfm import decode_pfm
from recon.settings import SequenceSettings
from tests.commands import answer
from tests.recordings import write_wall

SMALL = ["eyes.width=120", "eyes.height=96", "eyes.fov_deg=40", "render.noise=1.5"]

pytestmark = pytest.mark.usefixtures("without_figures")


def argv_of(settings):
    return [word for setting in settings for word in ("--set", setting)]


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    """A mesh of a wall of many colours, a grid of small squares."""
    path = tmp_path_factory.mktemp("mesh") / "wall.ply"
    write_wall(path)
    return path


@pytest.fixture(scope="module")
def drive(boxes, tmp_path_factory):
    """Three views along the wall."""
    folder = tmp_path_factory.mktemp("recording") / "drive"
    settings = argv_of([*SMALL, "eyes.baseline=0.4"])
    assert main(["render", str(boxes), "--views", "drive:3", *settings, "-o", str(folder)]) == 0
    return folder


def test_unit_of_a_calibration_is_metres_and_of_a_rendered_world_unknown(drive, tmp_path):
    (tmp_path / "par.txt").write_text("0\n")
    assert unit_of(drive.parent) == "m"
    assert unit_of(drive) is None
    assert unit_of(tmp_path) is None


def test_rendered_recording_is_read_with_its_poses_and_truth(drive):
    source = open_sequence(drive, SequenceSettings())
    pairs = list(source)
    assert len(pairs) == 3
    low, high = source.disparity_range
    depth = decode_pfm((drive / "depth" / "000001.pfm").read_bytes(), "depth")
    disparity = decode_pfm((drive / "disparity" / "000001.pfm").read_bytes(), "disparity")
    known = np.isfinite(depth)
    assert known.mean() > 0.2
    np.testing.assert_allclose(disparity[known], pairs[1].rig.disparity(depth[known]), atol=1e-3)
    assert low == 0
    assert np.nanmax(disparity) < high
    # The wall is the plane z = 0 of the world.
    v, u = np.nonzero(known)
    points = pairs[1].rig.rays(np.column_stack([u, v])) * depth[v, u, None]
    T = pairs[1].T_world_left
    np.testing.assert_allclose((points @ T[:3, :3].T + T[:3, 3])[:, 2], 0, atol=1e-4)


def test_images_are_reproducible_from_the_seed(boxes, tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        argv = ["render", str(boxes), "--views", "ring:2", "-o", str(tmp_path / name)]
        assert main([*argv, "--seed", str(seed), *argv_of(SMALL)]) == 0
    first, again, other = ((tmp_path / name / "left" / "000000.png").read_bytes() for name in "abc")
    assert first == again
    assert first != other


def test_surface_of_a_recording_is_evaluated_against_its_truth(drive, tmp_path, capsys):
    run = tmp_path / "run"
    report = answer(capsys, "reconstruct", drive, "--mesh", "--voxel", "0.05", "-o", run)
    assert report["num_triangles"] > 500
    judged = answer(capsys, "evaluate", "--surface", run, "--truth", drive)
    assert list(judged["fscore"]) == ["0.025", "0.05", "0.125"]
    assert judged["fscore"]["0.125"] > 0.9
    assert judged["accuracy_90"] < 0.1
    assert 0.6 < judged["completeness"] <= 1
    by_mesh = answer(
        capsys, "evaluate", "--surface", run, "--truth", drive / "scene.ply", "--distance", "0.1"
    )
    assert by_mesh["precision"]["0.1"] > 0.85
    # Negative control: a displaced surface is not near.
    moved = read_mesh(run / "mesh.ply").transformed(
        np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.5], [0, 0, 0, 1]])
    )
    write_mesh(tmp_path / "moved.ply", moved)
    wrong = answer(
        capsys, "evaluate", "--surface", tmp_path / "moved.ply", "--truth", drive,
        "--distance", "0.1",
    )  # fmt: skip
    assert wrong["fscore"]["0.1"] < 0.2
    again = answer(capsys, "mesh", run, "--voxel", "0.1", "-o", tmp_path / "coarse")
    assert 0 < again["num_triangles"] < report["num_triangles"]
    assert again["mesh_area"] == pytest.approx(report["mesh_area"], rel=0.3)


def test_run_without_its_recording_cannot_be_meshed(drive, tmp_path, capsys):
    assert main(["mesh", str(drive), "-o", str(tmp_path / "out")]) == 2
    assert "one of reconstruct or explore is needed" in capsys.readouterr().err


@pytest.mark.parametrize("views", ["ring:0", "ring:x", "spiral:3", "drive:"])
def test_invalid_views_are_rejected(boxes, tmp_path, capsys, views):
    assert main(["render", str(boxes), "--views", views, "-o", str(tmp_path / "out")]) == 2
    assert "is needed" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_views_are_read_from_a_file(boxes, tmp_path, capsys):
    (tmp_path / "views.txt").write_text("0 1.5 6 0 1.5 0\n1 1.5 6 1 1.5 0\n")
    report = answer(
        capsys, "render", boxes, "--views", tmp_path / "views.txt", "-o", tmp_path / "out",
        *argv_of(SMALL),
    )  # fmt: skip
    assert report["num_pairs"] == 2


@pytest.mark.parametrize(
    ("rows", "fault"),
    [
        ("1 2 3 4 5\n", ", line 1: '1 2 3 4 5', but x y z of position and target are needed"),
        ("# x y z\n0 1 6 0 1 0\nnan 1 6 0 1 0\n", ", line 3: 'nan 1 6 0 1 0', but x y z of"),
        ("0 1 6 0 1 here\n", ", line 1: '0 1 6 0 1 here', but x y z of position"),
        ("# none\n", " has 0 views, but 1 to 10000 are needed"),
    ],
)
def test_faulty_row_of_views_is_named(boxes, tmp_path, capsys, rows, fault):
    (tmp_path / "views.txt").write_text(rows)
    views = str(tmp_path / "views.txt")
    assert main(["render", str(boxes), "--views", views, "-o", str(tmp_path / "out")]) == 2
    assert f"{views}{fault}" in capsys.readouterr().err


def test_surface_and_truth_must_be_given_together(tmp_path, capsys):
    assert main(["evaluate", "--surface", str(tmp_path)]) == 2
    assert "--surface needs --truth FILE" in capsys.readouterr().err
    assert main(["evaluate", "--surface", str(tmp_path), "--truth", str(tmp_path)]) == 2
    assert "neither mesh.ply nor dense.ply" in capsys.readouterr().err


def test_surface_without_a_point_is_rejected(tmp_path, capsys):
    for name, points in (("full", np.eye(3)), ("empty", np.zeros((0, 3)))):
        write(PointCloud(points=points), tmp_path / f"{name}.ply")
    full, empty = (str(tmp_path / name) for name in ("full.ply", "empty.ply"))
    for surface, truth in ((full, empty), (empty, full)):
        assert main(["evaluate", "--surface", surface, "--truth", truth]) == 2
        assert "empty.ply contains neither triangles nor points" in capsys.readouterr().err


@pytest.fixture
def pair_dir(tmp_path):
    """A pair of a fronto-parallel plane at a disparity of 6 px, with its truth."""
    rng = np.random.default_rng(1)
    texture = cv2.GaussianBlur(rng.normal(size=(60, 120)), (0, 0), 1.0)
    texture = (128 + 45 * texture / texture.std()).clip(0, 255).astype(np.uint8)
    folder = tmp_path / "plane"
    folder.mkdir()
    cv2.imwrite(str(folder / "left.png"), texture[:, :90])
    cv2.imwrite(str(folder / "right.png"), texture[:, 6:96])
    cv2.imwrite(str(folder / "disp_left.png"), np.full((60, 90), 24, np.uint8))
    (folder / "meta.json").write_text('{"truth_scale": 4}')
    return folder


def test_dense_matching_is_evaluated_beside_its_peers(pair_dir, tmp_path, capsys):
    report = answer(capsys, "evaluate", pair_dir, "--dense", "-o", tmp_path / "out")
    rows = {row["matcher"]: row for row in report["pairs"]}
    assert list(rows) == ["recon", "hh", "sgbm", "bm"]
    own = rows["recon"]
    assert own["right_nonocc"] > 98
    assert own["covered"] == pytest.approx(own["right"] + own["wrong"])
    assert own["median_px"] < 0.1
    assert own["within_2_sigma"] > 80
    assert rows["hh"]["within_1_sigma"] is None
    assert report["mean"]["recon"]["right"] == own["right"]
    for name in ("plane_dense_errors", "plane_dense_sigmas"):
        assert (tmp_path / "out" / "figures" / f"{name}.png").stat().st_size > 5000
