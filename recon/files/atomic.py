"""Files that appear whole or not at all."""

import errno
import os
import re
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from recon.errors import check_path

PathLike = str | os.PathLike[str]

# A temporary name: process id, random token, target name.
_TEMPORARY = re.compile(r"\.(\d+)-[0-9a-f]{8}-(.+)")
_STALE_S = 60.0


@contextmanager
def atomic_path(path: PathLike) -> Iterator[Path]:
    """A temporary name beside `path`, renamed to `path` at the end.

    The temporary name keeps the suffix, by which writers choose the format. An existing `path` is
    replaced in one step, and stays untouched if the block raises. Temporary files of killed
    processes for the same name are removed.

    Raises
    ------
    OSError
        With the name of the target, for instance if the disk is full.
    """
    check_path(path)
    wanted = Path(path)
    if not wanted.parent.is_dir():
        # The error names the requested folder, not the temporary name.
        lack = errno.ENOTDIR if wanted.parent.exists() else errno.ENOENT
        raise OSError(lack, os.strerror(lack), str(wanted.parent))
    _remove_stale(wanted)
    temporary = wanted.with_name(f".{os.getpid()}-{secrets.token_hex(4)}-{wanted.name}")
    try:
        yield temporary
        temporary.replace(wanted)
    except OSError as error:
        if error.errno is None or error.filename not in (None, str(temporary), temporary):
            raise
        raise OSError(error.errno, os.strerror(error.errno), str(wanted)) from error
    finally:
        temporary.unlink(missing_ok=True)


def remove_temporaries(folder: Path) -> None:
    """Remove files of killed processes in and below a folder that no other process writes to."""
    for path in folder.rglob(".*"):
        if _TEMPORARY.fullmatch(path.name) and path.is_file():
            path.unlink(missing_ok=True)


def _remove_stale(wanted: Path) -> None:
    with os.scandir(wanted.parent) as entries:
        names = [entry.name for entry in entries if entry.name.startswith(".")]
    for name in names:
        match = _TEMPORARY.fullmatch(name)
        if match and match[2] == wanted.name and _is_stale(wanted.with_name(name), int(match[1])):
            wanted.with_name(name).unlink(missing_ok=True)


def _is_stale(path: Path, process: int) -> bool:
    """True if a temporary file has outlived its process; a recent one may be another machine's."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        with suppress(FileNotFoundError):  # another process may remove it at any moment
            return time.time() - path.stat().st_mtime > _STALE_S
    except (OSError, OverflowError):
        return False
    return False
