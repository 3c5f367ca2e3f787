"""The examples are short, run as users run them, and type-check as users see them."""

import os
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

import recon

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
PAIR = ROOT / "data" / "motorcycle"
MAX_LINES = 15


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run an example in this process, which has already loaded recon; return its output."""
    monkeypatch.chdir(tmp_path)

    def run_example(name, *arguments):
        monkeypatch.setattr(sys, "argv", [name, *map(str, arguments)])
        runpy.run_path(str(EXAMPLES / name), run_name="__main__")
        return capsys.readouterr().out

    return run_example


def test_two_images_are_matched(run):
    out = run("match_two_images.py", PAIR / "left.png", PAIR / "right.png", 64)
    matches = int(out.split("Matches(")[1].split()[0])
    assert matches > 10_000
    assert 0.02 < float(out.split("surer than ")[1].split()[0]) < 1.0


def test_map_of_a_folder_is_passed_to_other_libraries(run, tmp_path):
    run("folder_to_map.py", PAIR, "map.npz")
    assert recon.VoxelMap.load(tmp_path / "map.npz").num_cells > 1000
    out = run("map_to_open3d_and_pyvista.py", "map.npz", "cells.vtp")
    assert "PointCloud with" in out
    assert (tmp_path / "cells.vtp").stat().st_size > 10_000


def test_objects_of_a_cloud_are_named(run, tmp_path):
    rng = np.random.default_rng(7)
    angle, height = rng.uniform(0, 2 * np.pi, 6000), rng.uniform(0, 8, 6000)
    trunk = np.column_stack([2 * np.cos(angle), height, 2 * np.sin(angle)])
    sphere = rng.normal(size=(9000, 3))
    crown = (0, 12, 0) + 4 * sphere / np.linalg.norm(sphere, axis=1, keepdims=True)
    points = np.vstack([trunk, crown])
    cloud = recon.PointCloud(points=points, colours=np.full(points.shape, 90, np.uint8))
    recon.write(cloud, tmp_path / "tree.ply")
    assert run("name_objects.py", "tree.ply").startswith("apple tree at")


def test_custom_matcher_reconstructs_a_recording(tmp_path):
    """The example runs in a separate process, because its matcher stays registered."""
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / "own_matcher.py"), str(PAIR)],
        capture_output=True, text=True, cwd=tmp_path, check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split("Reconstruction(")[1].split()[0]) > 1000


def test_custom_source_is_explored(run):
    out = run("own_source.py", "three_apples", 2)
    assert "2 poses" in out
    assert out.split()[-1] == "limit"


def test_live_camera_gives_points(run, tmp_path):
    both = np.hstack([cv2.imread(str(PAIR / f"{side}.png")) for side in ("left", "right")])
    height, width = both.shape[:2]
    file = cv2.VideoWriter(
        str(tmp_path / "a.avi"), cv2.VideoWriter.fourcc(*"FFV1"), 5, (width, height)
    )
    for _ in range(2):
        file.write(both)
    file.release()
    lines = run("live_camera.py", PAIR / "calib.txt", tmp_path / "a.avi").splitlines()
    assert len(lines) == 2
    assert int(lines[1].split("matches, ")[1].split()[0]) > 5000


def test_every_example_is_short():
    files = sorted(EXAMPLES.glob("*.py"))
    assert len(files) == 7
    for file in files:
        lines = [line for line in file.read_text().splitlines() if line.strip()]
        assert len(lines) <= MAX_LINES, file.name


def test_examples_type_check_from_outside_and_wrong_calls_are_found(tmp_path):
    for file in EXAMPLES.glob("*.py"):
        shutil.copy(file, tmp_path)
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import recon\nrecon.VoxelMap('x')\nrecon.VoxelMpa\nrecon.fit()\n")
    # With the project's options, to reuse mypy's cache of recon.
    done = subprocess.run(
        [sys.executable, "-m", "mypy", str(tmp_path)],
        capture_output=True, text=True, cwd=ROOT, check=False,
    )  # fmt: skip
    found = re.findall(r"(\w+\.py:\d+): error:", done.stdout)
    assert found == [f"wrong.py:{n}" for n in (2, 3, 4)]
