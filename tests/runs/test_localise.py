"""`recon localise`: pairs of a drive are located in its map, others are not."""

import shutil

import numpy as np
import pytest
from PIL import Image

from recon.cli import main
from recon.runs import localise
from recon.runs.job import Job
from tests.commands import answer
from tests.recordings import render_drive

pytestmark = pytest.mark.usefixtures("without_figures")

SOME = ("000000", "000002", "000004")


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    return render_drive(tmp_path_factory.mktemp("drive"), 6)


@pytest.fixture(scope="module")
def run(drive, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "run"
    given = ["map.places=true", "map.cell_size=0.2", "map.min_count=1"]
    options = [word for one in given for word in ("--set", one)]
    made = ["reconstruct", str(drive), "-o", str(folder), "--quality", "fast"]
    assert main([*made, *options]) == 0
    return folder


def test_pairs_of_a_drive_are_located_in_its_map(drive, run, capsys):
    said = answer(capsys, "localise", run, drive)
    true = np.loadtxt(run / "trajectory.txt")[:, 1:4]
    found = [one["T_world_left"] for one in said["poses"]]
    assert len(found) == len(true)
    assert said["num_found"] >= 2
    for T_world_left, place in zip(found, true, strict=True):
        if T_world_left is not None:
            assert np.linalg.norm(np.array(T_world_left)[:3, 3] - place) < 0.05


def test_pairs_of_another_place_are_not_located(drive, run, capsys, tmp_path):
    elsewhere = tmp_path / "elsewhere"
    for path in (drive / side / f"{name}.png" for side in ("left", "right") for name in SOME):
        copy = elsewhere / path.relative_to(drive)
        copy.parent.mkdir(parents=True, exist_ok=True)
        Image.open(path).transpose(Image.Transpose.FLIP_TOP_BOTTOM).save(copy)
    shutil.copy(drive / "calib.txt", elsewhere)
    said = answer(capsys, "localise", run, elsewhere)
    assert said["num_found"] == 0
    assert len(said["poses"]) == len(SOME)
    assert all(one["T_world_left"] is None and one["reason"] for one in said["poses"])


def test_run_without_places_is_read_only_once(drive, run, tmp_path, monkeypatch):
    bare = tmp_path / "bare"
    shutil.copytree(run, bare)
    (bare / "places.npz").unlink()
    job = Job(kind="localise", inputs=(bare, drive))
    atlas, shown = localise.seen(bare, job)
    assert [pair.name for pair in shown] == [pair.name for pair in localise.shown(bare, job)]
    assert len(shown) == 6
    monkeypatch.setattr(localise, "MAX_SHOWN", 3)
    _, fewer = localise.seen(bare, job)
    assert [pair.name for pair in fewer] == ["000000", "000002", "000004"]
    stored, none = localise.seen(run, job)
    assert len(atlas) == len(stored)
    assert none is None


def test_folder_that_is_not_a_run_is_rejected(drive, tmp_path, capsys):
    assert main(["localise", str(tmp_path), str(drive)]) != 0
    assert "map.npz" in capsys.readouterr().err
