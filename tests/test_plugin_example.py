"""The example package: a plugin in every group, installed beside recon and used by name."""

import importlib
import json
import shutil
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest

import recon
from recon.cli import main
from recon.plugins import GROUPS

ROOT = Path(__file__).parents[1]
PLUGIN = ROOT / "docs" / "plugin"
PAIR = ROOT / "data" / "motorcycle"


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Install the package into a folder."""
    # Building leaves files in the source folder, so a copy is built.
    folder = tmp_path_factory.mktemp("plugin")
    source, target = shutil.copytree(PLUGIN, folder / "source"), folder / "installed"
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    pip = [sys.executable, "-m", "pip", "install", *options, "--target", target, source]
    subprocess.run(pip, check=True)
    return target


@pytest.fixture(autouse=True)
def plugged_in(installed, monkeypatch):
    monkeypatch.syspath_prepend(str(installed))
    importlib.invalidate_caches()
    yield
    for name in [name for name in sys.modules if name.startswith("recon_example")]:
        del sys.modules[name]


def test_every_plugin_group_has_a_part_and_a_page():
    for group in GROUPS:
        values = [entry.value for entry in entry_points(group=f"recon.{group}")]
        assert any(value.startswith("recon_example.") for value in values), group
        assert (PLUGIN / f"{group}.md").stat().st_size > 300, group
        assert f"({group}.md)" in (PLUGIN / "README.md").read_text()


def test_reader_and_matcher_of_the_plugin_reconstruct(tmp_path):
    ((pair),) = recon.open_sequence(PAIR)
    np.savez(
        tmp_path / "pair.npz", left=pair.left[None], right=pair.right[None],
        focal_px=pair.rig.focal_px, baseline=pair.rig.baseline,
    )  # fmt: skip
    done = recon.reconstruct(tmp_path / "pair.npz", matcher="blocks", max_disparity=70)
    assert len(done.trajectory) == 1
    assert done.map.num_cells > 500


def test_format_of_the_plugin_round_trips(tmp_path):
    points = np.random.default_rng(0).normal(size=(50, 3))
    recon.write(recon.PointCloud(points=points), tmp_path / "a.jsonl")
    assert main(["export", str(tmp_path / "a.jsonl"), str(tmp_path / "a.ply"), "-q"]) == 0
    again = recon.read(tmp_path / "a.ply")
    assert isinstance(again, recon.PointCloud)
    np.testing.assert_allclose(again.points, points, atol=1e-6)
    (tmp_path / "bad.jsonl").write_text("[1, 2]")
    assert main(["info", str(tmp_path / "bad.jsonl")]) == 2


def test_job_of_the_plugin_runs_in_a_batch(tmp_path, capsys):
    argv = ["batch", str(PAIR), "--command", "sharpness", "-j", "1", "--json"]
    assert main([*argv, "-o", str(tmp_path / "batch")]) == 0
    (job,) = json.loads(capsys.readouterr().out)["jobs"]
    assert job["state"] == "done"
    assert job["num_pairs"] == 1
    assert job["sharpness"] > 10
    assert (tmp_path / "batch" / "motorcycle" / "manifest.json").is_file()


def test_controller_renderer_and_recogniser_of_the_plugin_explore(tmp_path, capsys):
    argv = ["explore", "three_apples", "--controller", "carousel", "--renderer", "night", "--json"]
    argv += ["--recogniser", "height", "--max-pairs", "3", "-o", str(tmp_path / "run")]
    assert main(argv) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["num_pairs"] == 3
    assert {found["label"] for found in report["objects"]} <= {"tower", "block"}
    settings = (tmp_path / "run" / "settings.toml").read_text()
    assert 'renderer = "night"' in settings
    assert 'recogniser = "height"' in settings
    assert main(["figure", str(tmp_path / "run"), "--kind", "heights", "--data", "--json"]) == 0
    files = [Path(path) for path in json.loads(capsys.readouterr().out)["figures"]]
    assert {file.name for file in files} == {"heights.png", "heights.npz"}
