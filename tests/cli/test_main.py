"""The program as a person meets it: help, versions, one line for every known error."""

import json
import subprocess
import sys

import pytest

from recon.cli import main
from recon.cli.options import build_settings

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
    assert run(capsys, "--version")[:2] == (0, "recon, version 0.1.0\n")


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
        (["figure", "nowhere"], "nowhere is no run folder"),
        (["info", "nowhere"], "nowhere does not exist"),
    ],
)
def test_wrong_use_is_one_line_that_names_the_thing(capsys, tmp_path, monkeypatch, argv, message):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, *argv)
    assert code == 2
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("recon: ")
    assert message in err
    assert list(tmp_path.iterdir()) == []


def test_doctor_prints_one_json_document(capsys):
    code, out, _ = run(capsys, "doctor", "--json")
    assert code == 0
    checks = {check["name"]: check["ok"] for check in json.loads(out)["checks"]}
    assert checks["open3d"]
    assert checks["rendering"]


@pytest.mark.parametrize("roi", ["1,2,3", "a,b,c,d", "0,0,-5,5"])
def test_a_region_that_is_none_is_refused(capsys, roi):
    code, _, err = run(capsys, "reconstruct", "somewhere", "--roi", roi)
    assert code == 2
    assert "--roi" in err


def test_options_are_stronger_than_files_and_set_is_the_strongest(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("[matching]\nkeep = 10\nmax_disparity = 30\n[map]\ncell_size = 0.5\n")
    given = {
        "preset": "thesis", "settings_file": file, "quality": "fast",
        "overrides": ("matching.max_disparity=40",),
        "matching__keep": 20, "matching__max_disparity": 35, "matching__matcher": None,
    }  # fmt: skip
    settings = build_settings(given, {"map.cell_size": 3.0, "map.min_count": 7})
    assert (settings.matching.keep, settings.matching.max_disparity) == (20, 40)
    assert settings.matching.row_permission == 1
    assert settings.map.cell_size == 0.5
