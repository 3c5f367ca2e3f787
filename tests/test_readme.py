"""The README's commands, run as written, and the expected results for the village."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from recon.cli import main
from recon.settings import Settings
from recon.world.world import World

ROOT = Path(__file__).parents[1]
PROGRAM = ".venv/bin/recon"


def commands():
    lines = (ROOT / "README.md").read_text().splitlines()
    return [line.strip() for line in lines if line.strip().startswith(PROGRAM)]


@pytest.fixture(scope="module")
def readme(tmp_path_factory):
    """A folder like the project's in which every command of the README has run, in order."""
    folder = tmp_path_factory.mktemp("readme")
    for name in ("data", "scenes"):
        (folder / name).symlink_to(ROOT / name)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        codes = {line: main(shlex.split(line, comments=True)[1:]) for line in commands()}
    return folder, codes


def test_every_command_of_the_readme_works(readme):
    _, codes = readme
    assert len(codes) >= 5
    assert set(codes.values()) == {0}, codes


def test_run_of_the_village_has_the_documented_results(readme):
    folder, _ = readme
    found = json.loads((folder / "runs/walk/objects.json").read_text())["objects"]
    truth = World.from_file(ROOT / "scenes" / "village.scene", Settings()).objects
    assert sorted(o["label"] for o in found) == sorted(o.label for o in truth)
    for true in truth:
        nearest = min(found, key=lambda o: np.linalg.norm(np.array(o["centre"]) - true.centre))
        assert nearest["label"] == true.label
        assert np.linalg.norm(np.array(nearest["centre"]) - true.centre) < 1.0
        assert nearest["views"] >= 2


def test_images_of_the_readme_exist():
    text = (ROOT / "README.md").read_text()
    assert text.startswith("![")
    image = text[text.index("(") + 1 : text.index(")")]
    assert (ROOT / image).stat().st_size > 10_000


def test_python_code_of_the_readme_works(readme):
    folder, _ = readme
    (code,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    names: dict[str, object] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        exec(compile(code, "README.md", "exec"), names)
    assert len(names["matches"]) > 5000
    assert (folder / "runs" / "motorcycle.npz").exists()
    assert names["done"].map.num_cells > 1000
    assert not re.search(r"from recon|import recon\.", code)
