"""The golden real pair on the command line: results are within their bounds."""

import json
from pathlib import Path

import numpy as np
import pytest

from recon.cli import main
from recon.exports.ply import read_cloud_chunks
from recon.sequences.pfm import decode_pfm
from tests.described_objects import assert_described

PAIR = Path(__file__).parents[2] / "data" / "motorcycle"


@pytest.fixture(scope="module")
def expected():
    """The bounds, with the command that produced them."""
    return json.loads((PAIR / "expected.json").read_text())


def assert_within(document, bands):
    for name, (low, high) in bands.items():
        assert low <= document[name] <= high, f"{name} is {document[name]}"


def test_disparity_is_within_its_bounds(expected, tmp_path, capsys):
    argv = ["disparity", str(PAIR / "left.png"), str(PAIR / "right.png")]
    argv += ["--calib", str(PAIR / "calib.txt"), "--truth", str(PAIR / "disp_left.pfm")]
    assert main([*argv, "-o", str(tmp_path / "out"), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert_within(report, expected["disparity"])
    with np.load(tmp_path / "out" / "matches.npz", allow_pickle=False) as saved:
        assert len(saved["points_px"]) == report["num_matches"]
        assert (np.diff(saved["score"]) <= 0).all()
        assert len(np.unique(saved["points_px"], axis=0)) == report["num_matches"]
        probable = saved["probability"] >= 0.5
    with np.load(tmp_path / "out" / "figures" / "disparity.npz", allow_pickle=False) as drawn:
        # Improbable matches are not drawn.
        assert 0.8 * report["num_matches"] < len(drawn["points_px"]) < report["num_matches"]
        assert len(drawn["points_px"]) == probable.sum()


def test_dense_disparity_is_written_on_request(tmp_path, capsys):
    argv = ["disparity", str(PAIR / "left.png"), str(PAIR / "right.png"), "--quality", "fast"]
    argv += ["--max-disparity", "70", "--truth", str(PAIR / "disp_left.pfm"), "--json"]
    assert main([*argv, "-o", str(tmp_path / "out"), "--dense"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert 0.88 < report["dense_coverage"] < 0.99
    assert 91 < report["dense_success_nonocc"] <= 100
    found, sigma = (
        decode_pfm((tmp_path / "out" / name).read_bytes(), name)
        for name in ("dense.pfm", "dense_sigma.pfm")
    )
    assert np.isfinite(found).mean() == pytest.approx(report["dense_coverage"])
    np.testing.assert_array_equal(np.isfinite(sigma), np.isfinite(found))
    assert (tmp_path / "out" / "figures" / "dense.png").stat().st_size > 10_000
    assert main([*argv, "-o", str(tmp_path / "sparse")]) == 0
    assert not {name for name in json.loads(capsys.readouterr().out) if name.startswith("dense")}
    assert not (tmp_path / "sparse" / "dense.pfm").exists()


def test_swapped_images_give_wrong_disparities(tmp_path, capsys):
    argv = ["disparity", str(PAIR / "right.png"), str(PAIR / "left.png"), "--max-disparity", "70"]
    assert main([*argv, "--truth", str(PAIR / "disp_left.pfm"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["success_all"] < 30


def test_pair_is_reconstructed(expected, tmp_path, capsys):
    run = tmp_path / "run"
    assert main(["reconstruct", str(PAIR), "-o", str(run), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert_within(report, expected["reconstruct"])
    for found in json.loads((run / "objects.json").read_text())["objects"]:
        assert_described(found)
    (cloud, _), *_ = read_cloud_chunks(run / "cloud.ply")
    # The camera looks along -z in a world whose y is up, and the floor is grey.
    assert np.median(cloud.points[:, 2]) < -2
    low = cloud.colours[cloud.points[:, 1] < np.quantile(cloud.points[:, 1], 0.1)]
    assert np.ptp(low.astype(float).mean(axis=0)) < 25
    assert (cloud.sigma > 0).all()


def test_images_of_different_sizes_are_rejected_in_one_line(tmp_path, capsys):
    argv = ["disparity", str(PAIR / "left.png"), str(PAIR.parents[1] / "docs/images/village.png")]
    assert main(argv) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_invalid_image_is_rejected_in_one_line(tmp_path, capsys):
    fake = tmp_path / "left.png"
    fake.write_text("no image")
    assert main(["disparity", str(fake), str(PAIR / "right.png"), "-o", str(tmp_path / "o")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "left.png" in error
    assert not (tmp_path / "o").exists()
