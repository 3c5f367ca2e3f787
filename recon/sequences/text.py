"""Text of other people's files, bounded before it is believed."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError

MAX_BYTES = 1 << 26
"""Of a file of poses or times: a million rows."""
MAX_DEPTH = 32
"""Of brackets in brackets."""
_NESTING = {"[": 1, "{": 1, "]": -1, "}": -1}


def read_bytes(path: Path, max_bytes: int) -> bytes:
    """The bytes of a regular file.

    Raises
    ------
    InputError
        Where it cannot be read, is a device or a pipe, or is larger than `max_bytes`.
    """
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"{path} is not a regular file, but one is needed")
        size = path.stat().st_size
        if size > max_bytes:
            raise InputError(f"{path} has {size} bytes, but at most {max_bytes} are read")
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from error


def read_text(path: Path, max_bytes: int = MAX_BYTES) -> str:
    """A text file in UTF-8, with or without a mark of its byte order.

    Raises
    ------
    InputError
        Where it cannot be read or is no text.
    """
    try:
        return read_bytes(path, max_bytes).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path} cannot be read (it is no text)") from error


def read_lines(path: Path, max_bytes: int = MAX_BYTES) -> list[str]:
    """The lines of a text file, as `read_text` has it."""
    return read_text(path, max_bytes).splitlines()


def read_json(path: Path, max_bytes: int = MAX_BYTES) -> Any:
    """A JSON document.

    Raises
    ------
    InputError
        Where it is none, or nested deeper than any that is meant.
    """
    text = read_text(path, max_bytes)
    depth = np.cumsum([_NESTING[letter] for letter in text if letter in _NESTING] or [0])
    if depth.max() > MAX_DEPTH:
        raise InputError(f"{path} is nested {depth.max()} deep, but at most {MAX_DEPTH} is read")
    try:
        return json.loads(text)
    except ValueError as error:
        reason = str(error).partition("\n")[0]
        raise InputError(f"{path} is not a JSON document ({reason:.80})") from error


def is_finite(field: str) -> bool:
    """Whether a word is a finite number."""
    try:
        return bool(np.isfinite(float(field)))
    except ValueError:
        return False
