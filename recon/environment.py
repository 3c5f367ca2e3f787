"""The process environment that libraries need, set up before any of them is imported.

numba caches compiled kernels beside the source, else in the user's cache; if neither is writable (a
read-only installation, no home) it refuses to work. recon then caches them in a temporary folder
that nobody else can write to, or compiles them anew every time.
"""

import os
import stat
import sys
from pathlib import Path

PACKAGE = Path(__file__).parent

QUIET = {"OPENCV_LOG_LEVEL": "SILENT", "OPENCV_FFMPEG_LOGLEVEL": "-8"}
"""Silences OpenCV's own messages on stderr; recon reports a file's faults in its own line."""


def prepare() -> None:
    """Set unset variables: quiet libraries, and writable folders if there are none."""
    for name, value in QUIET.items():
        os.environ.setdefault(name, value)
    if not os.access(_home(), os.W_OK):
        fallback = _own_folder("matplotlib")
        if fallback is not None:
            os.environ.setdefault("MPLCONFIGDIR", str(fallback))
    if kernel_folder() is None:
        folder = _own_folder("kernels")
        if folder is None:
            from recon.libraries import compile_always  # late: this is read by `import recon`

            compile_always()
        else:
            os.environ["NUMBA_CACHE_DIR"] = str(folder)
            if "numba" in sys.modules:
                sys.modules["numba"].config.CACHE_DIR = str(folder)


def kernel_folder() -> Path | None:
    """The folder of numba's compiled kernels; None if every process compiles them anew."""
    asked = os.environ.get("NUMBA_CACHE_DIR")
    places = [Path(asked)] if asked else []
    places += [PACKAGE, *([_home() / ".cache" / "numba"] if _home().is_dir() else [])]
    return next((place for place in places if _is_writable(place)), None)


def _home() -> Path:
    """The user's home; a folder that does not exist if the user has none."""
    try:
        return Path.home()
    except RuntimeError:
        return Path("/nonexistent")


def _is_writable(folder: Path) -> bool:
    """True if files can be created in a folder, which is created if missing."""
    trial = folder / f".recon-{os.getpid()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Permission bits prove nothing: a disk may be read-only, and root is always permitted.
        os.close(os.open(trial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        trial.unlink()
    except OSError:
        return False
    return True


def _own_folder(name: str) -> Path | None:
    """A temporary folder that only this user can write to: its content is executed."""
    import tempfile

    try:
        base = Path(tempfile.gettempdir()) / f"recon-{os.getuid() if hasattr(os, 'getuid') else 0}"
        base.mkdir(mode=0o700, exist_ok=True)
        if not _is_own(base):
            base = Path(tempfile.mkdtemp(prefix="recon-"))
        folder = base / name
        folder.mkdir(mode=0o700, exist_ok=True)
    except OSError:
        return None
    return folder


def _is_own(folder: Path) -> bool:
    status = folder.lstat()
    others = stat.S_IWGRP | stat.S_IWOTH
    is_mine = not hasattr(os, "getuid") or status.st_uid == os.getuid()
    return stat.S_ISDIR(status.st_mode) and is_mine and not status.st_mode & others
