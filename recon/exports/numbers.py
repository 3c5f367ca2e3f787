"""Numbers parsed from text, and conversion to the types of a format."""

import re
import warnings
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.notices import notify

# Spellings of NaN and infinity by C libraries.
_NOT_A_NUMBER = re.compile(rb"[-+]?(?:nan\([a-z0-9]*\)|1\.#(?:qnan|snan|ind)\d*)", re.IGNORECASE)
_INFINITE = re.compile(rb"1\.#inf\d*", re.IGNORECASE)
_SHOWN = 40

REAL = frozenset({"u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"})
"""The types of a format that can hold every real number of up to 8 bytes, as numpy codes."""


def parsed(
    lines: Sequence[bytes], num_columns: int | None, separator: str | None = None
) -> NDArray[np.float64]:
    """The numbers (N, K) of lines of text.

    Raises
    ------
    InputError
        If a line has a different number of words, or a word that is not a number.
    """
    if not lines:
        return np.zeros((0, num_columns or 0))
    try:
        # loadtxt only warns if there is no data.
        with warnings.catch_warnings(action="error"):
            table = np.loadtxt(lines, np.float64, delimiter=separator, ndmin=2, comments=None)
    except (ValueError, UserWarning):
        table = _parsed_slowly(lines, separator)
    if num_columns is not None and table.shape[1] != num_columns:
        raise InputError(f"a row has {table.shape[1]} values, but {num_columns} are needed")
    return table


def _parsed_slowly(lines: Sequence[bytes], separator: str | None) -> NDArray[np.float64]:
    """Parse rarer spellings of NaN and infinity, too; an empty field is NaN."""
    rows = [
        [_number(word) for word in _words(_INFINITE.sub(b"inf", line), separator)] for line in lines
    ]
    for row, line in zip(rows, lines, strict=True):
        if len(row) != len(rows[0]):
            raise InputError(
                f"{_shown(line)} has {len(row)} values, but the first row has {len(rows[0])}"
            )
    return np.array(rows, np.float64)


def _words(line: bytes, separator: str | None) -> list[bytes]:
    words = line.split(None if separator is None else separator.encode())
    return [word.strip() or b"nan" for word in words]


def _number(word: bytes) -> float:
    try:
        # Python's float would accept underscores.
        return float(_NOT_A_NUMBER.sub(b"nan", word).replace(b"_", b"?"))
    except ValueError:
        raise InputError(f"{_shown(word)} is not a number") from None


def _shown(text: bytes) -> str:
    return repr(text[:_SHOWN].decode("latin-1"))


def whole(values: NDArray[Any], dtype: str | np.dtype[Any], name: str) -> NDArray[Any]:
    """Values converted to the type declared for them.

    Raises
    ------
    InputError
        If the type cannot hold them.
    """
    kind = np.dtype(dtype)
    if kind.kind == "f":
        with np.errstate(over="ignore"):
            found = values.astype(kind)
        lost = np.isinf(found) & np.isfinite(values)
        if lost.any():
            raise InputError(f"{name} is {values[lost][0]:g}, but {kind} is claimed for it")
        return found
    limits = np.iinfo(kind)
    # Written so that NaN fails too.
    fits = (values >= limits.min) & (values <= limits.max) & (values == np.floor(values))
    if not fits.all():
        raise InputError(f"{name} is {values[~fits][0]:g}, but {kind} is claimed for it")
    return values.astype(kind)


def narrowed(values: NDArray[Any], held: Collection[str]) -> NDArray[Any] | None:
    """The same values in one of the types `held`; None if none can represent them exactly."""
    if values.dtype.str[1:] in held:
        return values
    if values.dtype.kind not in "biuf":
        return None
    for code in ("u1", "i4", "f4", "f8"):
        if code in held and _is_exact(values, np.dtype(code)):
            return values.astype(code)
    return None


def _is_exact(values: NDArray[Any], kind: np.dtype[Any]) -> bool:
    if values.dtype.kind == "f" and kind.kind != "f":
        return False
    with np.errstate(over="ignore", invalid="ignore"):
        # A round trip: a direct comparison would convert integers to floats first.
        back = values.astype(kind).astype(values.dtype)
    return bool(np.array_equal(back, values, equal_nan=values.dtype.kind == "f"))


def held_columns(
    columns: dict[str, NDArray[Any]], held: Collection[str], place: object
) -> dict[str, NDArray[Any]]:
    """The columns in types of the format; a notice names those that it cannot store."""
    found = {name: narrowed(values, held) for name, values in columns.items()}
    drop_columns([name for name, values in found.items() if values is None], place)
    return {name: values for name, values in found.items() if values is not None}


def drop_columns(names: Sequence[str], place: object) -> None:
    """Notify of columns that are not written."""
    if names:
        notify("columns-dropped", f"{place}: cannot hold {', '.join(names)}; left out")


def leave_out(names: Sequence[str], place: object) -> None:
    """Notify of columns that are not read."""
    if names:
        notify("columns-dropped", f"{place}: {', '.join(names)} are not numbers; left out")
