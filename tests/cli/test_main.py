"""The command line: help, version, and one line for every known error."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import recon
from recon.cli import main
from recon.cli.objects import object_line
from recon.cli.options import build_settings
from recon.exports.formats import write
from recon.notices import notify
from recon.records import PointCloud

SCENES = Path(__file__).parents[2] / "scenes"

HEAVY = ("cv2", "open3d", "pyvista", "matplotlib", "numba", "scipy", "pydantic")


def run(capsys, *argv):
    code = main(argv)
    out, err = capsys.readouterr()
    return code, out, err


def test_help_names_every_command_and_loads_nothing_heavy():
    script = (
        "import sys; from recon.cli import main; code = main(['--help']);"
        f"print(code, [m for m in {HEAVY} if m in sys.modules])"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert result.stdout.endswith("0 []\n")
    for command in ("explore", "reconstruct", "disparity", "figure", "info", "doctor"):
        assert f"  {command} " in result.stdout


@pytest.mark.parametrize(
    "command", ["explore", "reconstruct", "disparity", "figure", "info", "doctor"]
)
def test_every_command_has_help_with_an_example(capsys, command):
    code, out, _ = run(capsys, command, "--help")
    assert code == 0
    assert f"Example: recon {command}" in out
    assert "--json" in out


def test_version(capsys):
    assert run(capsys, "--version")[:2] == (0, f"recon, version {recon.__version__}\n")


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["explore", "nowhere.scene"], "nowhere.scene"),
        (["explore"], "SCENE"),
        (["explore", "a.scene", "--max-pairs", "0"], "--max-pairs"),
        (["explore", "a.scene", "--set", "map.cel_size=1"], "map.cell_size"),
        (["explore", "a.scene", "--settings", "none.toml"], "none.toml"),
        (["exploer"], "exploer"),
        (["disparity", "a.png", "b.png"], "a.png"),
        (["reconstruct", "nowhere"], "nowhere does not exist"),
        (["figure", "nowhere"], "nowhere is not a run folder"),
        (["info", "nowhere"], "nowhere does not exist"),
        (["mesh", "nowhere"], "nowhere is not a run folder"),
        (["evaluate", "nowhere"], "nowhere is not a folder"),
        (["fit", "."], ". is a folder, but a file is needed"),
        (["disparity", "a.png", "b.png", "--resume"], "resume needs a run folder: give -o"),
        (["disparity", "a.png", "b.png", "--overwrite"], "overwrite needs a run folder"),
        (["explore", "village", "--overwrite", "--resume"], "exclude each other: give one"),
        (["disparity", "a.png", "b.png", "--truth-scale", "4"], "there is no truth: give --truth"),
        (["train", "a", "-o", "no/m.json"], "no is not a folder, but that of no/m.json is needed"),
        (["train", "a", "-o", ".", "--overwrite"], ". is a folder, but a file is needed"),
        (["learn", "a.ply", "--name", "a", "-o", "no/k.toml"], "no is not a folder, but that of"),
        (["train", "a", "./a", "-o", "model.json"], "a is given 2 times"),
        (["figure", "run", "--font-size", "nan"], "'--font-size': 'nan' is not a finite number"),
        (["figure", "run", "--size", "0x0"], "'--size': 0x0 is out of range: 100 to 8192 pixels"),
        (["figure", "run", "--size", "big"], "'--size': 'big' is not a size, but WxH"),
        (["export", "a", "b.ply", "--box", "0,0,0,1,0,1"], "'--box': '0,0,0,1,0,1' is not a box"),
        (["export", "a", "b.ply", "--box", "0,0,0,1,nan,1"], "is not a box, but x0,y0,z0,x1,y1"),
        (["info", ""], "'FILE': it is empty, but a path is needed"),
        (["disparity", "a", "b", "-o", ""], "'-o' / '--output': it is empty, but a path"),
        (["evaluate"], "PAIR_DIRS, --worlds, --trajectory or --surface is needed"),
        (["evaluate", "--dense"], "PAIR_DIRS is needed"),
        (["evaluate", "a", "--worlds", "2"], "--worlds and PAIR_DIRS exclude each other"),
        (["evaluate", "--worlds", "2", "--surface", "a"], "--surface and --worlds exclude each"),
        (["evaluate", "a", "--distance", "1"], "--distance does not belong to the evaluation of"),
        (["evaluate", "a", "--dense", "--matcher", "sgbm"], "--matcher does not belong to the"),
        (["evaluate", "--truth", "a"], "--truth does not belong to the evaluation of pairs"),
        (["evaluate", "--trajectory", "a"], "--trajectory needs --truth FILE"),
        (["disparity", ".", "."], ". is a folder, but a file is needed\n"),
        (["learn", "a.ply", "--name", "", "-o", "k.toml"], "name is '', but a word is needed"),
        (["settings", "map.cel"], "nearest known name is map.cell_size"),
        (["merge", "a", "./a"], "a is given 2 times"),
    ],
)
def test_wrong_use_is_reported_in_one_line(capsys, tmp_path, monkeypatch, argv, message):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, *argv)
    assert code == 2
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("recon: ")
    assert message in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "argv", [["settings", "map"], ["catalogue", "check", "village"], ["info", "a.ply"]]
)
def test_every_document_has_warnings(capsys, tmp_path, monkeypatch, argv):
    monkeypatch.chdir(tmp_path)
    write(PointCloud(points=np.zeros((1, 3))), tmp_path / "a.ply")
    code, out, err = run(capsys, *argv, "--json")
    assert (code, err) == (0, "")
    assert json.loads(out)["warnings"] == []


def test_notices_of_a_command_without_a_job_are_its_warnings(capsys, monkeypatch, tmp_path):
    def unpack(name, folder):
        for _ in range(2):
            notify("rows-differ", "by 3 px")
        return [folder / "left.png"]

    monkeypatch.setattr("recon.sequences.samples.fetch", unpack)
    code, out, err = run(capsys, "fetch", "motorcycle", "-o", str(tmp_path), "--json")
    assert (code, err) == (0, "recon: rows-differ: by 3 px\n")
    assert json.loads(out)["warnings"] == [{"code": "rows-differ", "text": "by 3 px"}]


def test_doctor_prints_one_json_document(capsys):
    code, out, _ = run(capsys, "doctor", "--json")
    assert code == 0
    checks = {check["name"]: check["ok"] for check in json.loads(out)["checks"]}
    assert checks["open3d"]
    assert checks["rendering"]


@pytest.mark.parametrize("roi", ["1,2,3", "a,b,c,d", "0,0,-5,5"])
def test_invalid_region_is_rejected(capsys, roi):
    code, _, err = run(capsys, "reconstruct", "somewhere", "--roi", roi)
    assert code == 2
    assert "--roi" in err


def test_options_override_files_and_set_overrides_both(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("[matching]\nkeep = 10\nmax_disparity = 30\n[map]\ncell_size = 0.5\n")
    given = {
        "preset": "thesis", "settings_file": file, "quality": "fast",
        "overrides": ("matching.max_disparity=40",),
        "matching__keep": 20, "matching__max_disparity": 35, "matching__matcher": None,
    }  # fmt: skip
    settings = build_settings(given)
    assert (settings.matching.keep, settings.matching.max_disparity) == (20, 40)
    assert settings.matching.max_row_offset_px == 1
    assert settings.map.cell_size == 0.5


@pytest.mark.parametrize("scale", ["nan", "inf", "0", "-1", "much"])
def test_scale_must_be_positive_and_finite(capsys, scale):
    code, _, err = run(capsys, "disparity", "a.png", "b.png", "--truth-scale", scale)
    assert code == 2
    assert "--truth-scale" in err


def test_unknown_matcher_is_rejected_with_the_known_ones(capsys, tmp_path):
    argv = ["--matcher", "foo", "--max-pairs", "1", "-o", str(tmp_path / "run")]
    code, _, err = run(capsys, "explore", str(SCENES / "three_apples.scene"), *argv)
    assert code == 2
    assert "matcher is 'foo', but one of phase" in err
    assert not (tmp_path / "run").exists()


def test_invalid_catalogue_is_reported_in_one_line(capsys, tmp_path):
    broken = tmp_path / "mine.toml"
    broken.write_bytes(b"\xff\xfe")
    cloud = tmp_path / "dot.ply"
    write(PointCloud(points=np.zeros((1, 3)), colours=np.zeros((1, 3), np.uint8)), cloud)
    code, _, err = run(capsys, "recognise", str(cloud), "--catalogue", str(broken))
    assert code == 2
    assert err.count("\n") == 1
    assert "mine.toml" in err


def test_excessive_size_is_rejected(capsys):
    code, _, err = run(capsys, "figure", "run", "--size", "999999x999999")
    assert code == 2
    assert "out of range" in err


@pytest.mark.parametrize(
    ("size", "said"),
    [
        (2.125, "at 0.00   2.12 x 1.06"),
        (0.02125, "at 0.000   0.021 x 0.011"),
        (0.0, "at 0.00   0.00 x 0.00"),
    ],
)
def test_object_sizes_are_readable_in_any_unit(size, said):
    box = {"sizes": [size, size / 2], "unit": None}
    found = {"label": "unknown", "centre": [-1e-9], "box": box, "probability": None}
    assert object_line(found) == f"unknown        {said}"
    # What has a name extends to the ground, below its lowest cell.
    named = found | {"label": "tree", "size": [4.0, 12.0, 4.0], "probability": 1.0}
    assert "4.0" in object_line(named)
    assert "12.0" in object_line(named)


def test_existing_run_is_refused_before_the_recording_is_read(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr("recon.runs.job.resolve", lambda job: pytest.fail("read"))
    for name in ("pair", "run"):
        (tmp_path / name).mkdir()
    code, _, err = run(capsys, "reconstruct", str(tmp_path / "pair"), "-o", str(tmp_path / "run"))
    assert code == 2
    assert "run exists; give --overwrite, --resume, or another -o" in err
