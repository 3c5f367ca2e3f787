"""Locks between processes, which vanish with the process that holds them."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from recon.errors import InputError


@contextmanager
def locked(path: Path, busy: str) -> Iterator[None]:
    """Hold the lock that a file stands for; the file is gone afterwards.

    Parameters
    ----------
    path : Path
        The file; its folder is there.
    busy : str
        What to say where another process holds the lock.

    Raises
    ------
    InputError
        Where another process that still lives holds it.
    """
    descriptor = _acquired(path)
    if descriptor is None:
        raise InputError(busy)
    try:
        yield
    finally:
        path.unlink(missing_ok=True)
        os.close(descriptor)


def _acquired(path: Path) -> int | None:
    """An open descriptor that holds the lock; None where another process does."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(descriptor)
            return None
        if _is_file_of(descriptor, path):
            return descriptor
        # Its holder took the file away between the two calls.
        os.close(descriptor)


def _is_file_of(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False
