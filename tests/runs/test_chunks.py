"""A map built in chunks is the same byte for byte, and every command reads its partitions."""

import json

import pytest

from recon.app.exhibit import open_exhibit
from recon.cli import main
from recon.exports import read
from recon.exports.partitions.partitioned import PartitionedMap
from recon.runs import maps
from tests.commands import answer
from tests.recordings import contents, render_drive

SETTINGS = ["--quality", "fast"]
for setting in ("map.cell_size=0.1", "map.max_sigma=none", "map.partition_size=64"):
    SETTINGS += ["--set", setting]
SHARED = ("cloud.ply", "objects.json", "trajectory.txt")


@pytest.fixture(scope="module")
def runs(tmp_path_factory, without_figures):
    """One run in one piece, and two in chunks."""
    folder = tmp_path_factory.mktemp("chunks")
    drive = render_drive(folder, 5)
    for name, given in {
        "whole": [],
        "twos": ["--chunk", "2"],
        "threes": ["--chunk", "3", "-j", "2"],
    }.items():
        argv = ["reconstruct", str(drive), "-o", str(folder / name), "-q", *SETTINGS, *given]
        assert main(argv) == 0
    return folder


def test_any_chunk_size_gives_the_same_bytes(runs):
    assert contents(runs / "twos" / "map.parquet") == contents(runs / "threes" / "map.parquet")
    assert len(PartitionedMap(runs / "twos" / "map.parquet")) > 1
    for name in SHARED:
        same = {(runs / run / name).read_bytes() for run in ("whole", "twos", "threes")}
        assert len(same) == 1, name
    metrics = [
        json.loads((runs / run / "metrics.json").read_text()) | {"seconds": None}
        for run in ("whole", "twos")
    ]
    assert metrics[0] == metrics[1]


def test_export_as_one_file_equals_the_map_of_one_run(runs, tmp_path):
    assert main(["export", str(runs / "twos"), str(tmp_path / "map.npz"), "-q"]) == 0
    assert (tmp_path / "map.npz").read_bytes() == (runs / "whole" / "map.npz").read_bytes()


@pytest.mark.parametrize("ending", [".ply", ".parquet", ".csv", ".glb"])
def test_streamed_exports_hold_the_same_cells(runs, ending, tmp_path, capsys):
    found = [
        answer(capsys, "export", runs / run, tmp_path / f"{run}{ending}")
        for run in ("whole", "twos")
    ]
    assert found[0]["num_cells"] == found[1]["num_cells"] > 100
    if ending != ".parquet":  # one row group per partition
        assert found[0]["bytes"] == found[1]["bytes"]
    if ending != ".glb":
        whole, streamed = (read(tmp_path / f"{run}{ending}") for run in ("whole", "twos"))
        assert sorted(map(tuple, whole.means)) == sorted(map(tuple, streamed.means))


def test_box_of_a_partitioned_map_is_that_of_the_whole(runs, tmp_path):
    box = ["--box", "-0.5,0.5,-1,0.5,1.5,1", "-q"]
    for run in ("whole", "twos"):
        assert main(["export", str(runs / run), str(tmp_path / f"{run}.npz"), *box]) == 0
    assert (tmp_path / "whole.npz").read_bytes() == (tmp_path / "twos.npz").read_bytes()


def test_partitioned_map_is_drawn_described_shown_and_recognised(runs, capsys):
    whole, twos = runs / "whole", runs / "twos"
    for run in (whole, twos):
        assert main(["figure", str(run), "--kind", "occupancy", "--data", "-q"]) == 0
    drawn = (twos / "figures" / "occupancy.png").read_bytes()
    assert drawn == (whole / "figures" / "occupancy.png").read_bytes()
    about = answer(capsys, "info", twos / "map.parquet")
    assert about["kind"] == "map"
    assert about["num_cells"] == answer(capsys, "info", whole / "map.npz")["num_cells"]
    shown, own = (open_exhibit(run).layers["map"] for run in (twos, whole))
    assert (shown.places == own.places).all()
    assert open_exhibit(twos / "map.parquet").layers["map.parquet"].noun == "cells"
    results = [answer(capsys, "recognise", one) for one in (whole, twos, twos / "map.parquet")]
    assert results[0] == results[1] == results[2]


def test_too_large_map_is_drawn_coarser_with_a_notice(runs, capsys, monkeypatch):
    monkeypatch.setattr(maps, "MAX_CELLS", 20)
    found = answer(capsys, "recognise", runs / "twos")
    codes = [one["code"] for one in found["warnings"]]
    assert codes == ["map-coarsened"]
    assert main(["figure", str(runs / "twos"), "--kind", "occupancy", "-q"]) == 0


def test_interrupted_run_is_resumed(runs, tmp_path, monkeypatch):
    drive, cut = runs / "drive", tmp_path / "cut"
    argv = ["reconstruct", str(drive), "-o", str(cut), "-q", *SETTINGS, "--chunk", "2"]

    def fail(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(maps, "merge_partitions", fail)
        assert main(argv) == 130
    assert main([*argv, "--resume"]) == 0
    assert contents(cut / "map.parquet") == contents(runs / "twos" / "map.parquet")
    assert not (cut / "partial").exists()
