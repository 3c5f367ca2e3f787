"""Heavy libraries are loaded by the commands that need them, and by no others."""

import json
import subprocess
import sys

import cv2
import numpy as np
import pytest

from recon.exports import write
from recon.records import PointCloud
from tests.sequences.recordings import image_pairs

HEAVY = ["open3d", "vtk", "vtkmodules", "pyvista", "pandas", "seaborn", "plotly", "dash", "nicegui"]
AFTER_EACH = """
import json, sys
from recon.cli import main
heavy, commands = map(json.loads, sys.argv[1:])
for command in commands:
    assert main(command) == 0, command
    loaded = [name for name in heavy if name in sys.modules]
    if loaded:
        sys.exit(f"{command} loads {loaded}")
"""
# pyarrow itself loads pandas where it is installed.
EXPORTS = ["b.pcd", "b.las", "b.npz", "b.csv", "b.pts", "b.npy", "b.glb", "b.zarr"]


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """A pair of images and a point cloud of a ball."""
    folder = tmp_path_factory.mktemp("light")
    for name, image in zip(("left.png", "right.png"), next(image_pairs()), strict=True):
        cv2.imwrite(str(folder / name), image)
    rays = np.random.default_rng(0).normal(size=(2000, 3))
    ball = 2.0 * rays / np.linalg.norm(rays, axis=1, keepdims=True) + [0.0, 2.0, 0.0]
    write(PointCloud(points=ball), folder / "a.ply")
    return folder


def after(commands, folder):
    words = [sys.executable, "-c", AFTER_EACH, json.dumps(HEAVY), json.dumps(commands)]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)


def test_disparity_and_most_exports_load_neither_open3d_nor_vtk(bench):
    done = after(
        [
            ["info", "a.ply"],
            ["info", "left.png"],
            ["fit", "a.ply"],
            ["disparity", "left.png", "right.png", "--quality", "fast"],
            ["recognise", "a.ply", "--set", "map.cell_size=0.2"],
            ["settings", "map.cell_size"],
            *(["export", "a.ply", target] for target in EXPORTS),
        ],
        bench,
    )
    assert done.returncode == 0, done.stderr


def test_commands_that_need_vtk_load_it(bench):
    (bench / "a.vtk").write_text(
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n1 2 3\n"
    )
    done = after([["info", "a.vtk"]], bench)
    assert done.returncode == 1
    assert "vtkmodules" in done.stderr


def test_explorer_loads_no_statistics_of_scipy():
    # They take as long as everything else that it loads.
    loads = "import sys, recon.runs.explore; sys.exit('scipy.stats' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", loads], check=False).returncode == 0
