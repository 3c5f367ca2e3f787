"""The imported package: lazy, complete, and of the same version everywhere."""

import ast
import importlib
import importlib.metadata
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import recon

ROOT = Path(__file__).parents[1]


def test_all_public_names_are_imported_lazily():
    script = "import sys, recon; print('numpy' in sys.modules, len(dir(recon)))"
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert out.stdout.split() == ["False", str(len(recon.__all__))]
    for name in recon.__all__:
        assert getattr(recon, name) is not None


def names_for_type_checkers():
    """Collect name and module of everything that `import recon` shows to type checkers."""
    tree = ast.parse((ROOT / "recon" / "__init__.py").read_text())
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    return {
        alias.asname: node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.asname == alias.name
    }


def test_names_for_type_checkers_match_the_public_names():
    seen = names_for_type_checkers()
    assert sorted(seen) == sorted(recon.__all__)
    for name, home in seen.items():
        assert getattr(importlib.import_module(home), name) is getattr(recon, name)


def test_package_is_marked_as_typed():
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    assert "py.typed" in data["package-data"]["recon"]
    assert (ROOT / "recon" / "py.typed").exists()


GPL = re.compile(r"\bA?GPL|GNU (Affero )?General Public", re.IGNORECASE)


def license_of(name):
    found = importlib.metadata.metadata(name)
    classifiers = [c for c in found.get_all("Classifier") or [] if c.startswith("License")]
    # Some packages put the full text of all licences into this field; a name is short.
    words = [found.get("License-Expression") or "", found.get("License") or ""]
    return "; ".join([*(word for word in words if len(word) < 100), *classifiers])


def required(name, seen):
    """Collect the dependencies of `name`, direct and indirect, without extras."""
    for line in importlib.metadata.requires(name) or []:
        wanted = Requirement(line)
        if wanted.marker and not wanted.marker.evaluate({"extra": ""}):
            continue
        if wanted.name not in seen:
            seen.add(wanted.name)
            required(wanted.name, seen)
    return seen


def test_no_required_dependency_is_under_the_gpl():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    seen = set()
    for line in project["dependencies"]:
        name = Requirement(line).name
        required(name, seen)
        seen.add(name)
    assert len(seen) > 15
    assert {name: word for name in seen if GPL.search(word := license_of(name))} == {}


def test_documented_size_of_an_installation_is_correct():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    names: set[str] = set()
    for line in project["dependencies"]:
        name = Requirement(line).name
        names |= {name.lower().replace("_", "-")} | {
            one.lower().replace("_", "-") for one in required(name, set())
        }
    files = [file for name in names for file in importlib.metadata.files(name) or []]
    gigabytes = sum(file.size or 0 for file in files) / 1e9
    (stated,) = re.findall(r"installation takes ([\d.]+) GB", (ROOT / "docs/start.md").read_text())
    assert gigabytes == pytest.approx(float(stated), rel=0.1)


@pytest.mark.parametrize("word", ["GPL-3.0-only", "License :: OSI Approved :: GNU General Public"])
def test_gpl_is_recognised(word):
    assert GPL.search(word)
    assert not GPL.search("LGPL-2.1; MIT; License :: OSI Approved :: GNU Lesser General Public")


def test_unknown_name_lists_the_known_ones():
    with pytest.raises(AttributeError, match=r"recon has no VoxelMpa, but .*VoxelMap"):
        recon.VoxelMpa  # noqa: B018 -- the access is what is tested


def test_version_is_the_same_everywhere():
    """The tag defines it; the citation names the first release in the changelog."""
    assert recon.__version__ == importlib.metadata.version("recon-stereo")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["dynamic"] == ["version"]
    assert "version" not in project
    (release, *_) = re.findall(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert f"version: {release}\n" in (ROOT / "CITATION.cff").read_text()
    git = ["git", "-C", str(ROOT), "tag", "--points-at", "HEAD"]
    tags = subprocess.run(git, capture_output=True, text=True, check=False).stdout.split()
    assert [tag for tag in tags if re.match(r"v?\d", tag)] in ([], [f"v{release}"])


def test_every_folder_of_the_package_is_a_package():
    folders = {path.parent for path in (ROOT / "recon").rglob("*.py")}
    assert [str(f) for f in folders if not (f / "__init__.py").exists()] == []


def test_constraints_pin_every_dependency_and_contain_no_url():
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
