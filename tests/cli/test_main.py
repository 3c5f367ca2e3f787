"""The program as a person meets it: help, versions, one line for every known error."""

import json
import subprocess
import sys

import pytest

from recon.cli import main

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
