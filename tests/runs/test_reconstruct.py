"""`recon reconstruct` of recordings that show nothing."""

import json

import pytest

from recon.cli import main
from tests.sequences.recordings import write_pair_dir


@pytest.mark.usefixtures("without_figures")
def test_run_without_points_says_so(tmp_path, capsys):
    pair = write_pair_dir(tmp_path / "pair")
    argv = ["reconstruct", str(pair), "--quality", "fast", "--roi", "0,0,5,5", "--json"]
    assert main([*argv, "-o", str(tmp_path / "run")]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["num_points"] == 0
    assert "no-points" in [one["code"] for one in report["warnings"]]
