"""An exploration on the command line: its files, and their reproducibility."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from recon.cli import main
from recon.exports.ply import read_cloud_chunks
from recon.runs import explore as explore_module
from recon.runs.events import Events
from recon.runs.execute import execute
from recon.runs.job import Job
from recon.settings import Settings, updated
from recon.voxelmap import VoxelMap
from tests.described_objects import assert_described

SCENES = Path(__file__).parents[2] / "scenes"
PAIRS = 6
FILES = {
    "manifest.json", "settings.toml", "trajectory.txt", "cloud.ply", "map.npz", "objects.json",
    "cameras.json",
    "metrics.json", "figures/map3d.png", "figures/solids.png", "figures/occupancy.png",
    "figures/labels.png",
    "figures/trajectory.png", "figures/disparity.png", "figures/disparity.npz",
    "figures/overview.png",
}  # fmt: skip


def explore(folder, *flags, scene="three_apples"):
    argv = ["explore", str(SCENES / f"{scene}.scene"), "-o", str(folder), "--quiet"]
    return main([*argv, "--max-pairs", str(PAIRS), *flags])


def comparable(folder):
    """Read every file but the manifest, and the metrics without their seconds."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name not in ("manifest.json", "metrics.json"):
            found[path.relative_to(folder).as_posix()] = path.read_bytes()
    metrics = json.loads((folder / "metrics.json").read_text())
    metrics.pop("seconds")
    return found | {"metrics.json": metrics}


def comparable_without_figures(folder):
    """Read all comparable files but the figures."""
    return {name: held for name, held in comparable(folder).items() if "figures/" not in name}


@pytest.fixture
def without_figures(monkeypatch):
    """Draw no figures in runs: they take most of the time."""
    monkeypatch.setattr(explore_module, "draw_run_figures", lambda *drawn: None)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "walk"
    assert explore(folder) == 0
    return folder


def test_run_folder_contains_the_documented_files(run):
    files = {p.relative_to(run).as_posix() for p in run.rglob("*") if p.is_file()}
    assert files == FILES
    assert json.loads((run / "manifest.json").read_text())["state"] == "finished"


def test_every_object_is_fully_described(run):
    objects = json.loads((run / "objects.json").read_text())["objects"]
    assert objects
    for found in objects:
        assert_described(found)


def test_files_of_a_run_are_consistent(run):
    metrics = json.loads((run / "metrics.json").read_text())
    trajectory = np.loadtxt(run / "trajectory.txt")
    clouds = list(read_cloud_chunks(run / "cloud.ply"))
    assert metrics["num_pairs"] == PAIRS == len(trajectory)
    assert metrics["stop_reason"] == "limit"
    assert metrics["num_points"] == sum(len(cloud) for cloud, _ in clouds)
    assert set(np.unique(np.concatenate([pair for _, pair in clouds]))) <= set(range(PAIRS))
    assert VoxelMap.load(run / "map.npz").num_cells > 0
    np.testing.assert_allclose(np.linalg.norm(trajectory[:, 4:], axis=1), 1, atol=1e-8)
    np.testing.assert_allclose(trajectory[:, 2], 5.0, atol=1e-8)


def test_same_command_gives_the_same_bytes(run, tmp_path):
    assert explore(tmp_path / "again") == 0
    assert comparable(tmp_path / "again") == comparable(run)


def interrupted_exploration(folder, monkeypatch, *flags, num_taken=2):
    """Run an exploration that is interrupted after some pairs."""
    take = explore_module.Recorder.take

    def cut_short(self, view):
        if self.num_taken == num_taken:
            raise KeyboardInterrupt
        return take(self, view)

    with monkeypatch.context() as patch:
        patch.setattr(explore_module.Recorder, "take", cut_short)
        assert explore(folder, *flags) == 130


@pytest.mark.usefixtures("without_figures")
def test_resumed_run_gives_the_same_bytes(run, tmp_path, monkeypatch):
    folder = tmp_path / "cut"
    interrupted_exploration(folder, monkeypatch)
    assert json.loads((folder / "manifest.json").read_text())["state"] == "interrupted"
    assert json.loads((folder / "metrics.json").read_text())["stop_reason"] == "interrupted"
    assert explore(folder, "--resume") == 0
    assert comparable_without_figures(folder) == comparable_without_figures(run)


@pytest.mark.usefixtures("without_figures")
def test_resumed_run_with_motion_errors_gives_the_same_bytes(tmp_path, monkeypatch):
    slip = ("--set", "motion.position_noise=0.1", "--set", "motion.heading_noise_deg=1")
    whole, folder = tmp_path / "whole", tmp_path / "cut"
    assert explore(whole, *slip) == 0
    interrupted_exploration(folder, monkeypatch, *slip, num_taken=4)
    assert explore(folder, *slip, "--resume") == 0
    assert comparable_without_figures(folder) == comparable_without_figures(whole)
    believed, true = (np.loadtxt(whole / f"trajectory{end}.txt") for end in ("", "_true"))
    assert 0.0 < np.abs(believed - true).max() < 2.0


def test_finished_run_is_left_unchanged(run):
    before = (run / "manifest.json").stat().st_mtime_ns
    assert explore(run, "--resume") == 0
    assert (run / "manifest.json").stat().st_mtime_ns == before
    assert explore(run) == 2
    assert explore(run, "--resume", "--seed", "1") == 2


def test_json_output_is_metrics_with_run_and_objects(run, capsys):
    scene = str(SCENES / "three_apples.scene")
    code = main(["explore", scene, "-o", str(run), "--resume", "--max-pairs", str(PAIRS), "--json"])
    report = json.loads(capsys.readouterr().out)
    assert code == 0
    assert report["run"] == str(run)
    assert {"num_pairs", "coverage", "curve", "seconds", "objects", "path_bound"} <= set(report)


def test_figures_are_redrawn_at_the_requested_size(run, capsys):
    assert main(["figure", str(run), "--kind", "occupancy", "--size", "320x300", "--json"]) == 0
    (path,) = json.loads(capsys.readouterr().out)["figures"]
    header = Path(path).read_bytes()[16:24]
    assert (int.from_bytes(header[:4]), int.from_bytes(header[4:])) == (320, 300)
    assert main(["figure", str(run), "--kind", "portrait"]) == 2
    assert main(["figure", str(run), "--kind", "labels", "--view", "top"]) == 2
    assert "has a fixed view" in capsys.readouterr().err
    assert main(["figure", str(run), "--size", "bigxbig"]) == 2


def test_file_names_include_view_and_format(run, capsys):
    before = (run / "figures" / "map3d.png").read_bytes()
    argv = ["figure", str(run), "--kind", "map3d", "--size", "300x240", "--json"]
    for more, name in (
        (["--view", "top"], "map3d_top.png"),
        (["--view", "30,20,30,0,2,0"], "map3d_30_20_30_0_2_0.png"),
        (["--view", "front", "--format", "pdf", "--no-title"], "map3d_front.pdf"),
    ):
        assert main([*argv, *more]) == 0
        (path,) = json.loads(capsys.readouterr().out)["figures"]
        assert Path(path).name == name
        assert Path(path).stat().st_size > 1000
    assert (run / "figures" / "map3d.png").read_bytes() == before


def test_dots_per_inch_keep_the_printed_size(run, capsys):
    argv = ["figure", str(run), "--kind", "occupancy", "--dpi", "50", "--json"]
    assert main(argv) == 0
    (path,) = json.loads(capsys.readouterr().out)["figures"]
    header = Path(path).read_bytes()[16:24]
    width, height = int.from_bytes(header[:4]), int.from_bytes(header[4:])
    assert width == 500
    assert 0.4 * 430 <= height <= 430


def test_labels_are_exported_to_map_formats(run, capsys):
    assert main(["figure", str(run), "--kind", "labels", "--data", "--json"]) == 0
    written = {Path(path).name for path in json.loads(capsys.readouterr().out)["figures"]}
    assert written == {
        "labels.png", "labels.npz", "labels.geojson", "map.pgm", "map.yaml", "labels.json",
    }  # fmt: skip
    objects = json.loads((run / "objects.json").read_text())["objects"]
    shown = json.loads((run / "figures" / "labels.geojson").read_text())["features"]
    polygons = [one for one in shown if one["geometry"]["type"] == "Polygon"]
    assert [one["properties"]["label"] for one in polygons] == [one["label"] for one in objects]
    labels = json.loads((run / "figures" / "labels.json").read_text())["labels"]
    for found, label in zip(objects, labels, strict=True):
        x, _, z = found["centre"]
        np.testing.assert_allclose(label["position"], [x, -z], atol=1e-5)


def test_damaged_npz_is_reported_in_one_line(run, capsys, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(run, copy)
    (copy / "figures" / "disparity.npz").write_bytes(b"PK nothing")
    assert main(["figure", str(copy), "--kind", "disparity"]) == 2
    assert "cannot be read" in capsys.readouterr().err


def test_every_figure_is_available_as_data(run, capsys):
    assert main(["figure", str(run), "--data", "--json"]) == 0
    paths = [Path(path) for path in json.loads(capsys.readouterr().out)["figures"]]
    data = {path.stem: np.load(path, allow_pickle=False) for path in paths if path.suffix == ".npz"}
    assert set(data) == {path.stem for path in paths if path.suffix == ".png"}
    metrics = json.loads((run / "metrics.json").read_text())
    assert len(data["labels"]["label"]) == metrics["num_objects"]
    assert data["occupancy"]["cells"].sum() == data["map3d"]["counts"].sum()
    assert len(data["trajectory"]["T_world_left"]) == PAIRS
    assert main(["figure", str(run), "--kind", "sigma"]) == 2
    assert "keeps no weights" in capsys.readouterr().err


@pytest.mark.usefixtures("without_figures")
def test_sigma_is_drawn_if_the_map_keeps_weights(tmp_path):
    folder = tmp_path / "weighed"
    assert explore(folder, "--set", 'map.occupancy=["count", "weight"]') == 0
    assert main(["figure", str(folder), "--kind", "sigma", "--data", "-q"]) == 0
    sigma = np.load(folder / "figures" / "sigma.npz", allow_pickle=False)["sigma_cells"]
    assert 0 < np.median(sigma) < 1


def test_info_describes_runs_maps_clouds_scenes_and_images(run, capsys):
    for name, kind in {
        ".": "run", "map.npz": "map", "cloud.ply": "cloud", "figures/map3d.png": "image",
    }.items():  # fmt: skip
        assert main(["info", str(run / name), "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["kind"] == kind
    assert main(["info", str(SCENES / "village.scene"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["num_visuals"] == 13


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("# Radius\n4", "# Radius\n-4", "-4"),
        ("# Radius\n4", "# Radius\nnan", "nan"),
        ("# Visual type\nSPHERE", "# Visual type\nPYRAMID", "PYRAMID"),
        ("textures/grass.tga", "textures/moss.tga", "moss"),
        ("# Radius\n4\n", "", "line"),
    ],
)
def test_broken_scene_is_reported_in_one_line_and_leaves_no_folder(
    tmp_path, capsys, old, new, message
):
    text = (SCENES / "village.scene").read_text()
    assert old in text
    broken = tmp_path / "broken.scene"
    broken.write_text(text.replace(old, new, 1))
    assert main(["explore", str(broken), "-o", str(tmp_path / "run")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "broken.scene:" in error
    assert not (tmp_path / "run").exists()


@pytest.mark.usefixtures("without_figures")
def test_progress_is_the_known_share_of_the_floor(tmp_path):
    progress = []
    events = Events(on_progress=lambda *now: progress.append(now))
    two = updated(Settings(), {"exploration": {"max_pairs": 2}})
    execute(Job(kind="explore", inputs=(SCENES / "three_apples.scene",), settings=two),
            tmp_path / "run", events)  # fmt: skip
    first, second = progress
    assert first[1] == second[1] == 100
    assert 5 < first[0] < 40
    assert first[0] <= second[0] < 100
