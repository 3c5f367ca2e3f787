"""Matchers compared on the command line."""

import json
import shutil
from pathlib import Path

import pytest
from PIL import Image

from recon.cli import main
from recon.sequences.pfm import write_pfm
from recon.sequences.truth import read_truth

PAIR = Path(__file__).parents[2] / "data" / "motorcycle"
ROWS = slice(150, 350)


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """The middle rows of the pair, which suffice to compare matchers in less than half the time."""
    folder = tmp_path_factory.mktemp("rows") / "motorcycle"
    folder.mkdir()
    for side in ("left.png", "right.png"):
        image = Image.open(PAIR / side)
        image.crop((0, ROWS.start, image.width, ROWS.stop)).save(folder / side)
    write_pfm(folder / "disp_left.pfm", read_truth(PAIR).disparity_px[ROWS])
    text = (PAIR / "calib.txt").read_text().replace("254.877", str(254.877 - ROWS.start))
    (folder / "calib.txt").write_text(text.replace("height=500", "height=200"))
    return folder


def test_two_matchers_are_compared(rows, tmp_path, capsys):
    out = tmp_path / "evaluation"
    argv = ["evaluate", str(rows), "--matcher", "phase", "--matcher", "sgbm", "--quality", "fast"]
    assert main([*argv, "--keep", "3000", "-o", str(out), "--json"]) == 0
    phase, sgbm = json.loads(capsys.readouterr().out)["pairs"]
    assert (phase["name"], phase["matcher"], sgbm["matcher"]) == ("motorcycle", "phase", "sgbm")
    assert phase["num_matches"] == sgbm["num_matches"] == 3000
    assert 0 < phase["num_mismatches"] / 3000 < 0.05
    assert 0.3 < phase["coverage"] < 1
    figures = {path.name for path in (out / "figures").iterdir()}
    assert "motorcycle_phase_errors.png" in figures
    assert "motorcycle_sgbm_tuning.png" in figures


def test_table_has_one_line_per_pair(rows, capsys):
    assert main(["evaluate", str(rows), "--quality", "fast"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2
    assert lines[0].split()[:3] == ["pair", "matcher", "num_matches"]
    assert lines[1].split()[:2] == ["motorcycle", "phase"]


def test_truth_of_the_right_image_decides_occlusion(rows, tmp_path, capsys):
    """A right truth that confirms nothing leaves no point that is visible to both."""
    folder = shutil.copytree(rows, tmp_path / "pair")
    right = read_truth(rows).disparity_px + 50
    write_pfm(folder / "disp_right.pfm", right)
    argv = ["evaluate", str(rows), str(folder), "--matcher", "sgbm", "--json"]
    assert main(argv) == 0
    without, with_right = json.loads(capsys.readouterr().out)["pairs"]
    assert with_right["success_all"] == without["success_all"]
    assert without["success_nonocc"] > 90
    assert with_right["success_nonocc"] is None


def test_pair_without_truth_is_rejected_in_one_line(tmp_path, capsys):
    assert main(["evaluate", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "disp_left" in error


def test_pairs_of_the_same_name_are_rejected(capsys):
    assert main(["evaluate", str(PAIR), str(PAIR)]) == 2
    assert "named motorcycle" in capsys.readouterr().err


def test_given_search_range_overrides_that_of_the_pair(rows, capsys):
    """The pair states a range of 0 to 70, but its disparities are 6 to 59."""
    argv = ["evaluate", str(rows), "--matcher", "sgbm", "--quality", "fast", "--json"]
    assert main([*argv, "--set", "matching.max_disparity=20"]) == 0
    said = capsys.readouterr()
    (narrow,) = json.loads(said.out)["pairs"]
    assert "search-range-too-small" in said.err
    assert main(argv) == 0
    said = capsys.readouterr()
    (wide,) = json.loads(said.out)["pairs"]
    assert "search-range-too-small" not in said.err
    assert narrow["num_matches"] < 0.9 * wide["num_matches"]


def test_trained_model_is_used(rows, tmp_path, capsys):
    model = tmp_path / "model.json"
    assert main(["train", str(rows), "-o", str(model), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["num_pairs"] == 1
    argv = ["evaluate", str(rows), "--matcher", "vonmises", "--keep", "3000", "--json"]
    argv += ["--set", f"matching.model={model}"]
    assert main([*argv, "-o", str(tmp_path / "out")]) == 0
    (row,) = json.loads(capsys.readouterr().out)["pairs"]
    assert 98 < row["success_all"] <= 100
    assert (tmp_path / "out/figures/motorcycle_vonmises_mixture.png").stat().st_size > 10_000
    model.write_text("{}")
    assert main(argv) == 2
    assert main(["train", str(rows), "-o", str(model)]) == 2
