"""The true disparity beside a pair, sound or not, on the command line."""

import json
import re

import numpy as np
import pytest

from recon.cli import main
from recon.sequences import images
from recon.sequences.pfm import write_pfm
from recon.sequences.truth import read_truth
from tests.sequences.recordings import write_pair_dir

pytestmark = pytest.mark.usefixtures("without_figures")


@pytest.fixture
def pair(tmp_path):
    """A pair whose truth is in floats."""
    folder = write_pair_dir(tmp_path / "pair")
    truth = read_truth(folder).disparity_px
    (folder / "disp_left.png").unlink()
    write_pfm(folder / "disp_left.pfm", truth)
    return folder


def changed(folder, change):
    write_pfm(folder / "disp_left.pfm", change(read_truth(folder).disparity_px))


def reconstructed(pair, tmp_path, *more):
    argv = ["reconstruct", str(pair), "--quality", "fast", "--json", *more]
    return main([*argv, "-o", str(tmp_path / "run")])


def counting(function, calls):
    def counted(*given):
        calls.append(given)
        return function(*given)

    return counted


def codes(report):
    return [one["code"] for one in report["warnings"]]


def test_sound_truth_gives_a_distance(pair, tmp_path, capsys):
    assert reconstructed(pair, tmp_path) == 0
    report = json.loads(capsys.readouterr().out)
    assert 0 <= report["surface_distance_median"] < 0.1
    assert "truth-disagrees" not in codes(report)


def test_truth_costs_no_further_reading_of_its_pair(pair, tmp_path, monkeypatch):
    read = []
    monkeypatch.setattr(images, "read_pixels", counting(images.read_pixels, read))
    assert reconstructed(pair, tmp_path) == 0
    with_truth = len(read)
    (pair / "disp_left.pfm").unlink()
    assert reconstructed(pair, tmp_path, "--overwrite") == 0
    assert len(read) - with_truth == with_truth


@pytest.mark.parametrize("factor", [-1.0, 16.0])
def test_truth_of_another_sign_or_scale_is_reported(pair, tmp_path, capsys, factor):
    changed(pair, lambda truth: factor * truth)
    assert reconstructed(pair, tmp_path) == 0
    assert "truth-disagrees" in codes(json.loads(capsys.readouterr().out))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda truth: truth[:20], r"truth is \d+ x 20 pixels, but the left image has"),
        (lambda truth: truth * np.nan, "contains no known disparity, but truth is needed"),
    ],
)
@pytest.mark.parametrize("command", ["reconstruct", "evaluate"])
def test_truth_that_cannot_judge_is_refused(pair, tmp_path, capsys, command, change, reason):
    changed(pair, change)
    argv = [command, str(pair), "--quality", "fast", "-o", str(tmp_path / "run")]
    assert main(argv) == 2
    (line,) = [one for one in capsys.readouterr().err.splitlines() if "compiling" not in one]
    assert re.search(reason, line)


def test_truth_of_the_whole_image_does_not_judge_a_region(pair, tmp_path, capsys):
    assert reconstructed(pair, tmp_path, "--roi", "8,8,40,32") == 0
    assert "surface_distance_median" not in json.loads(capsys.readouterr().out)


def test_disparity_without_known_pixels_is_described(tmp_path):
    write_pfm(tmp_path / "dense.pfm", np.full((4, 6), np.nan))
    assert main(["info", str(tmp_path / "dense.pfm")]) == 0
