"""recon works where its libraries find no place to write, and says nothing of it but in doctor."""

import ctypes
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from recon import environment, libraries
from recon.errors import MissingLibraryError

SOURCE = Path(environment.__file__).parent
PR_CAPBSET_DROP, CAP_DAC_OVERRIDE = 24, 1
KERNEL = """
import recon, numpy as np
from recon.environment import kernel_folder
from recon.stereo.kernels.angle import angles
print(kernel_folder())
"""


@pytest.fixture
def read_only(tmp_path):
    """A copy of the package that nobody may write, and a folder for temporary files."""
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(SOURCE, tmp_path / "site" / "recon", ignore=ignored)
    for path in (tmp_path / "site").rglob("*"):
        path.chmod(0o555 if path.is_dir() else 0o444)
    (tmp_path / "site").chmod(0o555)
    (tmp_path / "temporary").mkdir()
    yield tmp_path
    for path in (tmp_path / "site", *(tmp_path / "site").rglob("*")):
        path.chmod(0o755)


def as_anybody():
    """Give up what lets root write what is read-only (CAP_DAC_OVERRIDE), before a child begins."""
    ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0)


def run(code, path, **variables):
    """A child that may write in the folder for temporary files only."""
    known = {
        "PATH": os.environ["PATH"], "PYTHONPATH": str(path / "site"), "HOME": str(path / "site"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }  # fmt: skip
    return subprocess.run(
        [sys.executable, "-c", code], env=known | variables, cwd=path, text=True,
        capture_output=True, check=False, preexec_fn=as_anybody,
    )  # fmt: skip


@pytest.fixture
def cannot_write(read_only):
    probe = f"open({str(read_only / 'site' / 'trial')!r}, 'w')"
    if not run(probe, read_only).returncode:
        pytest.skip("this user writes what is read-only")


@pytest.mark.usefixtures("cannot_write")
def test_a_read_only_package_without_a_home_keeps_kernels_in_a_folder_of_its_own(read_only):
    temporary = read_only / "temporary"
    done = run(KERNEL, read_only, TMPDIR=str(temporary))
    assert (done.returncode, done.stderr) == (0, "")
    folder = Path(done.stdout.strip())
    assert folder.is_relative_to(temporary)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.usefixtures("cannot_write")
def test_a_folder_that_others_can_write_is_not_trusted(read_only):
    temporary = read_only / "temporary"
    own = temporary / f"recon-{os.getuid()}"
    own.mkdir()
    own.chmod(0o777)
    done = run(KERNEL, read_only, TMPDIR=str(temporary))
    assert (done.returncode, done.stderr) == (0, "")
    folder = Path(done.stdout.strip())
    assert folder.parent != own
    assert folder.is_relative_to(temporary)


def test_without_any_place_kernels_are_compiled_and_not_kept(monkeypatch):
    told = []
    monkeypatch.setattr(environment, "kernel_folder", lambda: None)
    monkeypatch.setattr(environment, "_own_folder", lambda name: None)
    monkeypatch.setattr(libraries, "compile_always", lambda: told.append(True))
    environment.prepare()
    assert told == [True]


def test_what_is_writable_is_kept_as_it_is(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "mine"))
    environment.prepare()
    assert environment.kernel_folder() == tmp_path / "mine"
    (tmp_path / "file").touch()
    assert not environment._is_writable(tmp_path / "file" / "below")


@pytest.mark.parametrize("name", ["with a space", "Ümläut"])
def test_names_of_folders_and_the_locale_do_not_matter(tmp_path, name):
    from tests.sequences.recordings import write_pair_dir

    pair = write_pair_dir(tmp_path / name)
    code = (
        "import sys; from recon.cli.main import main;"
        f"sys.exit(main(['info', {str(pair)!r}, '--json']))"
    )
    poor = {"LANG": "C", "LC_ALL": "C", "DISPLAY": ":99"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | poor, capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize(
    ("message", "raised"),
    [
        ("KeyboardInterrupt: <EMPTY MESSAGE>", KeyboardInterrupt),
        ("libGL.so.1: cannot open shared object file", MissingLibraryError),
    ],
)
def test_ctrl_c_while_open3d_loads_is_ctrl_c(monkeypatch, message, raised):
    def fail(name):
        raise ImportError(message)

    monkeypatch.setattr(libraries, "importlib", SimpleNamespace(import_module=fail))
    monkeypatch.setitem(sys.modules, "open3d", None)
    with pytest.raises(raised):
        libraries.load_open3d.__wrapped__()
