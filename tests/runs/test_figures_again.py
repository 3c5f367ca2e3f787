"""Figures of runs without a map are redrawn from the saved results."""

import json
from pathlib import Path

import numpy as np
import pytest

from recon.cli import main
from recon.exports import write
from recon.records import PointCloud

PAIR = Path(__file__).parents[2] / "data" / "motorcycle"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("again") / "pair"
    argv = ["disparity", str(PAIR / "left.png"), str(PAIR / "right.png"), "--max-disparity", "70"]
    assert main([*argv, "-o", str(folder), "-q"]) == 0
    return folder


def test_figures_of_a_pair_are_redrawn(run, capsys):
    before = (run / "figures" / "disparity.png").read_bytes()
    (run / "figures" / "disparity.png").unlink()
    assert main(["figure", str(run), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["figures"] == [
        str(run / "figures" / "disparity.png")
    ]
    assert (run / "figures" / "disparity.png").read_bytes() == before


def test_missing_content_of_a_run_is_reported_in_one_line(run, capsys):
    lacks = {"map3d": "no map.npz", "errors": "has no data", "overview": "has no data"}
    for kind, said in lacks.items():
        assert main(["figure", str(run), "--kind", kind]) == 2
        assert said in capsys.readouterr().err


def test_incomplete_arrays_are_reported_in_one_line(run, capsys):
    np.savez(run / "figures" / "other_errors.npz", kind=np.array("errors"), left=np.zeros((4, 5)))
    assert main(["figure", str(run), "--kind", "errors"]) == 2
    assert "points_px" in capsys.readouterr().err
    (run / "figures" / "other_errors.npz").unlink()


def test_mesh_without_triangles_is_no_figure(run, capsys):
    write(PointCloud(points=np.zeros((0, 3))), run / "mesh.ply")
    assert main(["figure", str(run), "--kind", "mesh"]) == 2
    assert "has no mesh.ply with triangles" in capsys.readouterr().err
    assert main(["figure", str(run), "-q"]) == 0
    (run / "mesh.ply").unlink()
