"""Text of untrusted files, with limits."""

from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.files import check_regular, documents

MAX_BYTES = 1 << 26
"""Maximum size of a file of poses or times: a million rows."""


def read_bytes(path: Path, max_bytes: int) -> bytes:
    """The bytes of a regular file.

    Raises
    ------
    InputError
        If it cannot be read, is a device or a pipe, or is larger than `max_bytes`.
    """
    try:
        check_regular(path)
        size = path.stat().st_size
        if size > max_bytes:
            raise InputError(f"{path} has {size} bytes, but at most {max_bytes} are read")
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from error


def read_text(path: Path, max_bytes: int = MAX_BYTES) -> str:
    """A text file in UTF-8, with or without a byte order mark.

    Raises
    ------
    InputError
        If it cannot be read or is not text.
    """
    try:
        return documents.read_text(path, max_bytes)
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from error


def read_lines(path: Path, max_bytes: int = MAX_BYTES) -> list[str]:
    """The lines of a text file, read by `read_text`."""
    return read_text(path, max_bytes).splitlines()


def is_finite(field: str) -> bool:
    """True if a word is a finite number."""
    try:
        return bool(np.isfinite(float(field)))
    except ValueError:
        return False
