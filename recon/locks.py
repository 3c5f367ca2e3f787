"""Locks between processes, released when the holding process ends."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from recon.errors import InputError


@contextmanager
def locked(path: Path, busy: str) -> Iterator[None]:
    """Hold the lock of a folder, the file `.NAME.lock` beside it, which is removed afterwards.

    Parameters
    ----------
    path : Path
        The folder, which need not exist; the one that contains it must.
    busy : str
        Message of the error if another process holds the lock.

    Raises
    ------
    InputError
        If another live process holds it.
    OSError
        With the name of the folder if the file cannot be created in it.
    """
    lock = path.with_name(f".{path.name}.lock")
    descriptor = _acquired(lock)
    if descriptor is None:
        raise InputError(busy)
    try:
        yield
    finally:
        lock.unlink(missing_ok=True)
        os.close(descriptor)


def _acquired(path: Path) -> int | None:
    """An open descriptor that holds the lock; None if another process does."""
    while True:
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            # Nobody asked for the lock file; the folder is what cannot be written.
            raise OSError(error.errno, error.strerror, str(path.parent)) from error
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(descriptor)
            return None
        if _is_file_of(descriptor, path):
            return descriptor
        # The holder removed the file between the two calls.
        os.close(descriptor)


def _is_file_of(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False
