"""The package as it is imported: late, whole, and the same version everywhere."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import recon

ROOT = Path(__file__).parents[1]


def test_public_names_come_late_and_all_of_them_come():
    script = "import sys, recon; print('numpy' in sys.modules, len(dir(recon)))"
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert out.stdout.split() == ["False", str(len(recon.__all__))]
    for name in recon.__all__:
        assert getattr(recon, name) is not None


def test_an_unknown_name_says_what_there_is():
    with pytest.raises(AttributeError, match=r"recon has no VoxelMpa, but .*VoxelMap"):
        recon.VoxelMpa  # noqa: B018 -- the access is what is tested


def test_the_version_is_that_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["version"] == recon.__version__
    assert f"## {recon.__version__}" in (ROOT / "CHANGELOG.md").read_text()


def test_every_folder_of_the_package_is_a_package():
    folders = {path.parent for path in (ROOT / "recon").rglob("*.py")}
    assert [str(f) for f in folders if not (f / "__init__.py").exists()] == []


def test_constraints_pin_what_the_project_asks_for_and_name_no_address():
    text = (ROOT / "constraints.txt").read_text()
    pinned = {line.partition("==")[0].lower().replace("_", "-") for line in text.splitlines()}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    wanted = project["dependencies"] + [
        one for name in extras if name != "all" for one in extras[name]
    ]
    names = {w.split(">=")[0].split("[")[0].lower().replace("_", "-") for w in wanted}
    assert names <= pinned, names - pinned
    assert "://" not in text
    assert "@" not in text
