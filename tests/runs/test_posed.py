"""The cameras of a run, for COLMAP and nerfstudio."""

import dataclasses
import json

import numpy as np
import pytest

from recon.errors import InputError
from recon.geometry import pose
from recon.records import Trajectory
from recon.runs.cameras import CAMERAS, SeenCamera, cameras_text
from recon.runs.execute import execute
from recon.runs.job import Job
from recon.runs.posed import export_poses
from recon.sequences.pose_files import read_poses
from tests.sequences.recordings import NUM_PAIRS, RIG, write_folder

pytestmark = pytest.mark.usefixtures("without_figures")

OTHER = dataclasses.replace(RIG, focal_px=90.0)


@pytest.fixture
def run(tmp_path):
    """A run of two pairs with different cameras."""
    path = tmp_path / "run"
    path.mkdir()
    (path / "manifest.json").write_text("{}")
    poses = np.stack([pose(np.eye(3), [0.0, 0.0, float(n)]) for n in range(2)])
    way = Trajectory(stamps_s=np.arange(2.0), T_world_left=poses)
    (path / "trajectory.txt").write_text(way.as_tum())
    seen = [SeenCamera(name="000000", rig=RIG), SeenCamera(name="000001", rig=OTHER)]
    (path / CAMERAS).write_text(cameras_text(seen))
    return path


def test_different_cameras_are_distinguished(run, tmp_path):
    export_poses(run, tmp_path / "transforms.json")
    frames = json.loads((tmp_path / "transforms.json").read_text())["frames"]
    assert [frame["fl_x"] for frame in frames] == [80.0, 90.0]
    export_poses(run, tmp_path / "images.txt")
    rows = (tmp_path / "cameras.txt").read_text().splitlines()[1:]
    assert [row.split()[:5] for row in rows] == [
        ["1", "PINHOLE", "96", "64", "80.0"],
        ["2", "PINHOLE", "96", "64", "90.0"],
    ]
    images = (tmp_path / "images.txt").read_text().splitlines()[1::2]
    assert [image.split()[8] for image in images] == ["1", "2"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{}", "is damaged"),
        ('{"rigs": [{"width": 3}], "pairs": []}', "is damaged"),
        ('{"rigs": [], "pairs": [{"name": "a", "rig": 0}]}', "is damaged"),
        ('{"rigs": [], "pairs": []}', "has 0 cameras, but 2 poses"),
        (None, "is missing"),
    ],
)
def test_run_without_its_cameras_is_rejected(run, tmp_path, text, message):
    (run / CAMERAS).unlink()
    if text is not None:
        (run / CAMERAS).write_text(text)
    with pytest.raises(InputError, match=message):
        export_poses(run, tmp_path / "images.txt")


def test_reconstruction_names_cameras_after_its_images(tmp_path):
    recording = write_folder(tmp_path / "drive")
    execute(Job(kind="reconstruct", inputs=(recording,)), tmp_path / "run")
    report = export_poses(tmp_path / "run", tmp_path / "transforms.json")
    assert report["num_poses"] == NUM_PAIRS
    given = read_poses(tmp_path / "transforms.json")
    assert given.names == tuple(f"left/{n:06d}.png" for n in range(NUM_PAIRS))
    way = Trajectory.from_tum((tmp_path / "run/trajectory.txt").read_text())
    np.testing.assert_allclose(given.poses, way.T_world_left, atol=1e-8)
