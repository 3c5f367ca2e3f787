"""recon works silently where its libraries cannot write; only `recon doctor` mentions it."""

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
    """A read-only copy of the package, and a folder for temporary files."""
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(SOURCE, tmp_path / "site" / "recon", ignore=ignored)
    for path in (tmp_path / "site").rglob("*"):
        path.chmod(0o555 if path.is_dir() else 0o444)
    (tmp_path / "site").chmod(0o555)
    (tmp_path / "temporary").mkdir()
    yield tmp_path
    for path in (tmp_path / "site", *(tmp_path / "site").rglob("*")):
        path.chmod(0o755)


def drop_root_override():
    """Drop root's right to write read-only files (CAP_DAC_OVERRIDE) before a child starts."""
    ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0)


def run(code, path, **variables):
    """Run a child process that may write only to the folder for temporary files."""
    known = {
        "PATH": os.environ["PATH"], "PYTHONPATH": str(path / "site"), "HOME": str(path / "site"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }  # fmt: skip
    return subprocess.run(
        [sys.executable, "-c", code], env=known | variables, cwd=path, text=True,
        capture_output=True, check=False, preexec_fn=drop_root_override,
    )  # fmt: skip


@pytest.fixture
def without_root_override(read_only):
    probe = f"open({str(read_only / 'site' / 'trial')!r}, 'w')"
    if not run(probe, read_only).returncode:
        pytest.skip("this user writes what is read-only")


@pytest.mark.usefixtures("without_root_override")
def test_read_only_package_without_a_home_caches_kernels_in_a_private_folder(read_only):
    temporary = read_only / "temporary"
    done = run(KERNEL, read_only, TMPDIR=str(temporary))
    assert (done.returncode, done.stderr) == (0, "")
    folder = Path(done.stdout.strip())
    assert folder.is_relative_to(temporary)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.usefixtures("without_root_override")
def test_world_writable_folder_is_not_trusted(read_only):
    temporary = read_only / "temporary"
    own = temporary / f"recon-{os.getuid()}"
    own.mkdir()
    own.chmod(0o777)
    done = run(KERNEL, read_only, TMPDIR=str(temporary))
    assert (done.returncode, done.stderr) == (0, "")
    folder = Path(done.stdout.strip())
    assert folder.parent != own
    assert folder.is_relative_to(temporary)


def test_kernels_are_compiled_without_a_cache_if_no_folder_is_writable(monkeypatch):
    told = []
    monkeypatch.setattr(environment, "kernel_folder", lambda: None)
    monkeypatch.setattr(environment, "_own_folder", lambda name: None)
    monkeypatch.setattr(libraries, "compile_always", lambda: told.append(True))
    environment.prepare()
    assert told == [True]


def test_writable_cache_folder_is_used_unchanged(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "mine"))
    environment.prepare()
    assert environment.kernel_folder() == tmp_path / "mine"
    (tmp_path / "file").touch()
    assert not environment._is_writable(tmp_path / "file" / "below")


@pytest.mark.parametrize("name", ["with a space", "Ümläut"])
def test_folder_names_and_locale_do_not_matter(tmp_path, name):
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
def test_ctrl_c_during_the_import_of_open3d_is_kept(monkeypatch, message, raised):
    def fail(name):
        raise ImportError(message)

    monkeypatch.setattr(libraries, "importlib", SimpleNamespace(import_module=fail))
    monkeypatch.setitem(sys.modules, "open3d", None)
    with pytest.raises(raised):
        libraries.load_open3d.__wrapped__()
