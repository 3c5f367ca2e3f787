"""Release artefacts: a source archive and a wheel built from it, tested in isolation."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
VERSION = "7.8.9"
"""Version of the tag of the release that is built here."""
SUPPORTED = ("3.11", "3.12", "3.13")
EXPECTED_FILES = {
    "recon/py.typed", "recon/stereo/vonmises_venus.json", "recon/world/shipped/village.scene",
    "recon/world/shipped/brick.png", "recon/recognition/naming/catalogues/village.toml",
}  # fmt: skip
PARSE_SOURCES = """
import ast, recon, sys
from pathlib import Path
for file in Path(recon.__file__).parent.rglob("*.py"):
    ast.parse(file.read_bytes(), file)
sys.exit(recon.__version__ != sys.argv[1])
"""
READ_SHIPPED_FILES = """
import recon
from recon.recognition.naming.catalogue import read_catalogues
from recon.stereo.matching.vonmises import load_model
from recon.world.library import find_scene, scene_names
from recon.world.scene import read_scene
from recon.world.textures import scene_files
for name in scene_names():
    assert all(file.is_file() for file in scene_files(read_scene(find_scene(name))))
assert len(read_catalogues(["village", "household"])) > 5
load_model(None)
"""


def run(*words, cwd=None):
    # Git as nobody has set it up: the user's may sign commits, or be in the middle of one.
    others = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    done = subprocess.run(
        [*map(str, words)], cwd=cwd, capture_output=True, text=True, check=False,
        env=others | {"GIT_CONFIG_GLOBAL": os.devnull},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def dist(tmp_path_factory):
    """The two files of a release, built from a copy of the project."""
    folder = tmp_path_factory.mktemp("release")
    kept = shutil.ignore_patterns("__pycache__", "*.nb[ci]")
    shutil.copytree(ROOT / "recon", folder / "recon", ignore=kept)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder)
    (folder / ".gitignore").write_text("dist/\n*.egg-info/\n")
    git = ["git", "-C", folder, "-c", "user.name=a", "-c", "user.email=a@b"]
    run("git", "init", "-q", folder)
    run(*git, "add", ".")
    run(*git, "commit", "-q", "-m", "Release")
    run(*git, "tag", "-m", "Release", f"v{VERSION}")
    # The wheel is built from the archive, which has no history.
    run(sys.executable, "-m", "build", "--no-isolation", folder)
    return folder / "dist"


@pytest.mark.parametrize("has_history", [False, True])
def test_untagged_sources_have_a_version(tmp_path, has_history):
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    if has_history:
        run("git", "init", "-q", tmp_path)
        run("git", "-C", tmp_path, "-c", "user.name=a", "-c", "user.email=a@b",
            "commit", "-q", "--allow-empty", "-m", "First")  # fmt: skip
    said = run(sys.executable, "-m", "setuptools_scm", cwd=tmp_path).strip()
    assert re.fullmatch(r"0\.0\.1\.dev1\+g[0-9a-f]+" if has_history else r"0\.0\.0", said)


@pytest.fixture(scope="module")
def wheel(dist):
    (found,) = dist.glob("*.whl")
    return found


def test_wheel_contains_exactly_what_recon_needs(wheel):
    assert wheel.name == f"recon_stereo-{VERSION}-py3-none-any.whl"
    names = set(zipfile.ZipFile(wheel).namelist())
    assert names >= EXPECTED_FILES
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert [name for name in names if not name.startswith(("recon/", "recon_stereo-"))] == []
    sources = {path.relative_to(ROOT).as_posix() for path in (ROOT / "recon").rglob("*.py")}
    assert sources <= names
    assert wheel.stat().st_size < 3_000_000


def test_source_archive_contains_the_same(dist):
    (archive,) = dist.glob("*.tar.gz")
    with tarfile.open(archive) as held:
        names = {name.partition("/")[2] for name in held.getnames()}
    assert names >= EXPECTED_FILES | {"LICENSE", "pyproject.toml"}


def pythons():
    """Find every supported Python on this machine."""
    found = []
    for version in SUPPORTED:
        places = [shutil.which(f"python{version}")]
        places += sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python"))
        for place in filter(None, places):
            words = [place, "-c", "import ensurepip"]
            if subprocess.run(words, capture_output=True, check=False).returncode == 0:
                found.append(pytest.param(place, id=version))
                break
    return found


def environment(python, folder, wheel):
    """Make a fresh environment with the wheel but without its dependencies."""
    run(python, "-m", "venv", "--without-pip", folder)
    inner = folder / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", inner, "install", "--no-compile"]
    run(*pip, "--quiet", "--no-index", "--no-deps", "--disable-pip-version-check", wheel)
    return inner


@pytest.mark.parametrize("python", pythons())
def test_wheel_installs_on_every_python(python, wheel, tmp_path):
    inner = environment(python, tmp_path / "env", wheel)
    run(inner, "-I", "-c", PARSE_SOURCES, VERSION, cwd=tmp_path)


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """The same with the libraries of the current environment, but not its recon."""
    folder = tmp_path_factory.mktemp("installed")
    inner = environment(sys.executable, folder / "env", wheel)
    (site,) = folder.glob("env/lib/python*/site-packages")
    (site / "libraries.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return inner


def test_installed_recon_finds_its_shipped_files_from_any_folder(installed, tmp_path):
    home = run(installed, "-I", "-c", "import recon; print(recon.__file__)", cwd=tmp_path)
    assert Path(home.strip()).is_relative_to(installed.parents[1])
    run(installed, "-I", "-c", READ_SHIPPED_FILES, cwd=tmp_path)
    program = installed.parent / "recon"
    assert VERSION in run(program, "--version", cwd=tmp_path)
    run(program, "fetch", "motorcycle", "-o", "motorcycle", cwd=tmp_path)
    assert (tmp_path / "motorcycle/left.png").is_file()


@pytest.mark.slow
def test_installed_recon_explores_and_serves_pages(installed, tmp_path):
    program = installed.parent / "recon"
    run(program, "explore", "village", "--max-pairs", "2", cwd=tmp_path)
    run(program, "demo", "--overwrite", "--set", "exploration.max_pairs=2", cwd=tmp_path)
    assert (tmp_path / "runs/village/figures/overview.png").is_file()
