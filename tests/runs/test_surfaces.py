"""Surfaces on the command line: files, metrics, and rejected input."""

import json
import shutil

import cv2
import numpy as np
import pytest

from recon.cli import main
from recon.exports.formats import read
from recon.exports.ply import read_mesh
from recon.sequences.pfm import decode_pfm
from recon.world.world import World
from tests.commands import answer

pytestmark = pytest.mark.usefixtures("without_figures")


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    """Three views of a textured wall 4 units away, the camera moving sideways."""
    folder = tmp_path_factory.mktemp("wall")
    rng = np.random.default_rng(3)
    texture = cv2.GaussianBlur(rng.normal(size=(60, 400)), (0, 0), 1.2)
    texture = (128 + 50 * texture / texture.std()).clip(0, 255).astype(np.uint8)
    # Focal length 100 px, baseline 0.2, depth 4: a disparity of 5 px, and 25 px per unit.
    for number in range(3):
        start = 100 + 5 * number
        for side, shift in (("left", 0), ("right", 5)):
            (folder / side).mkdir(exist_ok=True)
            image = texture[:, start + shift : start + shift + 80]
            cv2.imwrite(str(folder / side / f"{number}.png"), image)
    rows = [f"1 0 0 {0.2 * number} 0 1 0 0 0 0 1 0" for number in range(3)]
    (folder / "poses.txt").write_text("\n".join(rows) + "\n")
    (folder / "calib.txt").write_text(
        "P0: 100 0 39.5 0 0 100 29.5 0 0 0 1 0\nP1: 100 0 39.5 -20 0 100 29.5 0 0 0 1 0\n"
    )
    return folder


def reconstruct(drive, run, capsys, *options):
    search = ("--set", "matching.max_disparity=12")
    return answer(capsys, "reconstruct", drive, "-o", run, *search, *options)


MESH = ("--mesh", "--voxel", "0.1", "--quality", "fast")


@pytest.fixture(scope="module")
def wall(drive, tmp_path_factory):
    """A run that has the surface of the wall."""
    run = tmp_path_factory.mktemp("runs") / "wall"
    argv = ["reconstruct", str(drive), "-o", str(run), "--set", "matching.max_disparity=12"]
    assert main([*argv, *MESH, "--depth", "--quiet"]) == 0
    return run


def metrics_of(run):
    return json.loads((run / "metrics.json").read_text())


def test_wall_becomes_a_cloud_and_a_mesh(wall):
    run, report = wall, metrics_of(wall)
    mesh = read_mesh(run / "mesh.ply")
    # The camera looks along -z in a world whose y is up.
    np.testing.assert_allclose(np.median(mesh.vertices[:, 2]), -4, atol=0.05)
    assert mesh.colours is not None
    assert report["num_triangles"] == len(mesh)
    assert report["mesh_area"] == pytest.approx(mesh.area, rel=1e-3)
    assert 0.8 < report["dense_share"] <= 1
    assert report["dense_confirmed_share"] > 0.8
    cloud = read(run / "dense.ply")
    assert len(cloud) == report["num_dense_points"]
    assert cloud.colours is not None
    assert (cloud.sigma > 0).all()
    assert cloud.attributes["views"].max() == 3
    assert (run / "figures" / "mesh.png").stat().st_size > 5000
    depth = decode_pfm((run / "depth" / "000001.pfm").read_bytes(), "depth")
    steps = cv2.imread(str(run / "depth" / "000001.png"), cv2.IMREAD_UNCHANGED)
    assert steps.dtype == np.uint16
    known = np.isfinite(depth)
    np.testing.assert_allclose(steps[known], 1000 * depth[known], atol=0.51)
    assert (steps[~known] == 0).all()


def test_surface_is_written_only_on_request(drive, tmp_path, capsys):
    report = reconstruct(drive, tmp_path / "run", capsys)
    assert "num_dense_points" not in report
    assert not list((tmp_path / "run").glob("dense*"))
    assert not (tmp_path / "run" / "mesh.ply").exists()


@pytest.mark.parametrize("command", ["reconstruct", "explore"])
def test_size_of_voxels_without_a_surface_is_refused(drive, tmp_path, capsys, command):
    source = str(drive) if command == "reconstruct" else "three_apples"
    assert main([command, source, "-o", str(tmp_path / "run"), "--voxel", "0.1"]) == 2
    assert "surface.voxel is 0.1, but no surface is made: give" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("option", ["--dense", "--mesh"])
def test_mesh_has_no_options_for_what_it_always_makes(tmp_path, capsys, option):
    assert main(["mesh", str(tmp_path), option]) == 2
    assert f"No such option '{option}'" in capsys.readouterr().err


def test_same_command_gives_the_same_bytes(wall, drive, tmp_path, capsys):
    reconstruct(drive, tmp_path / "again", capsys, *MESH)
    for file in ("mesh.ply", "dense.ply"):
        assert (tmp_path / "again" / file).read_bytes() == (wall / file).read_bytes()


def test_pairs_are_fused_at_loop_closed_poses(wall, drive, tmp_path, capsys, monkeypatch):
    def moved(source, mapper, places, work):
        poses = mapper.trajectory.T_world_left.copy()
        poses[:, 0, 3] += 10
        mapper.repose(poses, [])
        return {}

    monkeypatch.setattr("recon.runs.reconstruct.may_close", lambda source: True)
    monkeypatch.setattr("recon.runs.reconstruct.close_drive", moved)
    reconstruct(drive, tmp_path / "moved", capsys, *MESH)
    before, after = (read_mesh(run / "mesh.ply") for run in (wall, tmp_path / "moved"))
    assert len(after) == pytest.approx(len(before), rel=0.02)
    shift = after.vertices.mean(axis=0) - before.vertices.mean(axis=0)
    np.testing.assert_allclose(shift, [10, 0, 0], atol=0.02)
    assert not (tmp_path / "moved" / "views").exists()


def test_every_pixel_is_added_to_the_map_on_request(wall, drive, tmp_path, capsys):
    sparse = metrics_of(wall)
    dense = reconstruct(
        drive, tmp_path / "dense", capsys, "--set", "map.points=dense", "--quality", "fast"
    )
    assert dense["num_points"] > 3 * sparse["num_points"]
    assert dense["num_voxels"] >= sparse["num_voxels"]


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """An exploration of five views with its surface."""
    run = tmp_path_factory.mktemp("runs") / "walk"
    argv = ["explore", "three_apples", "-o", str(run), "--max-pairs", "5", "--quiet"]
    assert (
        main([*argv, "--controller", "thesis", "--dense", "--mesh", "--voxel", "0.3", "--depth"])
        == 0
    )
    return run


def test_exploration_writes_a_surface(walk):
    metrics = json.loads((walk / "metrics.json").read_text())
    cloud, mesh = read(walk / "dense.ply"), read_mesh(walk / "mesh.ply")
    assert len(cloud) == metrics["num_dense_points"] > 1000
    assert len(mesh) == metrics["num_triangles"] > 100
    world = World.from_file("three_apples")
    assert np.median(world.surface_distance(cloud.points)) < 0.5
    assert np.median(world.surface_distance(mesh.vertices)) < 0.3
    assert np.median(world.surface_distance(mesh.vertices + np.array([0, 0, 2]))) > 0.6
    depths = sorted(path.name for path in (walk / "depth").glob("*.pfm"))
    assert depths == [f"{number:06}.pfm" for number in range(5)]


def test_mesh_of_an_exploration_renders_its_world_again(walk, tmp_path, capsys):
    run = tmp_path / "mesh"
    assert main(["mesh", str(walk), "-o", str(run), "--voxel", "0.3", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["num_pairs"] == 5
    world, mesh = World.from_file("three_apples"), read_mesh(run / "mesh.ply")
    assert np.median(world.surface_distance(mesh.vertices)) < 0.7
    assert np.median(world.surface_distance(mesh.vertices + np.array([0, 0, 2]))) > 1.5


def test_mesh_needs_a_run_with_images(walk, tmp_path, capsys):
    other = tmp_path / "other"
    shutil.copytree(walk, other)
    manifest = json.loads((other / "manifest.json").read_text())
    (other / "manifest.json").write_text(json.dumps(manifest | {"command": "fit"}))
    assert main(["mesh", str(other), "-o", str(tmp_path / "a")]) == 2
    assert "is a run of fit, but one of reconstruct or explore is needed" in capsys.readouterr().err
    gone = manifest | {"input_paths": [str(tmp_path / "gone.scene")]}
    (other / "manifest.json").write_text(json.dumps(gone))
    assert main(["mesh", str(other), "-o", str(tmp_path / "a")]) == 2
    assert "give --recording PATH" in capsys.readouterr().err


def test_depth_of_the_fullest_view_is_drawn_and_redrawn(walk, capsys):
    assert (walk / "figures" / "depth.png").stat().st_size > 5000
    assert main(["figure", str(walk), "--kind", "depth", "--format", "svg"]) == 0
    assert "depth [world units]" in (walk / "figures" / "depth.svg").read_text()
