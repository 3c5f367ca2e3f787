"""Points as rows of text (.xyz .txt .asc .csv .pts), columns identified by a header or by range."""

import codecs
import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.columns import NORMAL, RGB, XYZ, Columns
from recon.exports.elevation import grid_points, is_grid
from recon.exports.format import Format, table
from recon.exports.headings import heading
from recon.exports.names import as_words
from recon.exports.numbers import REAL, drop_columns, held_columns, leave_out, parsed
from recon.files import atomic_path, check_memory

_COMMENTS = (b"#", b"//", b"%", b"!", b";", b"sep=")
"""Beginnings of comments, and the first line of spreadsheets, which states the separator."""
_SEPARATORS = (";", ",", "\t")
_SKIPPED = "_"
_CHUNK_ROWS = 1 << 16

_HEADER_LINES = 20
_MAX_LINE_BYTES = 50_000
_TURNS = {"qw", "q_w", "qx", "q_x"}
"""Columns that indicate a trajectory."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Table:
    """The parsed structure of a file."""

    names: tuple[str, ...] | None
    """Names from the header; None if there is none."""
    rows: Sequence[bytes]
    separator: str | None
    claimed: int | None
    """Number of points claimed by the first line, as in .pts."""


def read(path: Path, columns: Sequence[str] | None = None) -> Columns:
    """The numeric columns.

    Parameters
    ----------
    path : path
    columns : sequence of str, optional
        Names of the columns in order, `_` for one to skip; by default from the header, or from
        their number and range: coordinates, then intensity, colours and normals.

    Raises
    ------
    InputError
        If a row is truncated, or contains a word that is not a number.
    """
    check_memory(path, 6.0 * path.stat().st_size)
    content = path.read_bytes()
    if is_grid(content):
        return grid_points(content)
    found = _split(content)
    if not found.rows and found.names is None:
        raise InputError("it holds no points")
    if found.claimed is not None and len(found.rows) < found.claimed:
        raise InputError(f"{found.claimed} points are claimed, but {len(found.rows)} follow")
    names = tuple(columns) if columns else found.names
    values, texts = _values(found, names)
    names = names or names_by_kind(values)
    _check_names(names)
    if len(names) != values.shape[1] + len(texts):
        raise InputError(f"a row has {values.shape[1]} values, but {len(names)} are named")
    leave_out([names[n] for n in texts if names[n] != _SKIPPED], path)
    numbers = [name for n, name in enumerate(names) if n not in texts]
    return {
        name: _typed(values[:, n], name, found.rows)
        for n, name in enumerate(numbers)
        if name != _SKIPPED
    }


def _check_names(names: Sequence[str]) -> None:
    twice = [name for name in names if name != _SKIPPED and names.count(name) > 1]
    if twice:
        raise InputError(f"two columns are named {twice[0]}: name all columns (--columns)")


def _split(content: bytes) -> _Table:
    lines = [line.strip() for line in _utf8(content).splitlines()]
    lines = [line for line in lines if line]
    comments = [line for line in lines[:100] if line.startswith(_COMMENTS)]
    rows = [line for line in lines if not line.startswith(_COMMENTS)]
    if max(map(len, rows), default=0) > _MAX_LINE_BYTES:
        raise InputError(f"a line has more than {_MAX_LINE_BYTES} bytes; is it a table of points?")
    names = next((n for line in reversed(comments) if (n := heading(line))), None)
    claimed = None
    if rows and rows[0].isdigit() and len(rows[0]) < 16:
        claimed, rows = int(rows[0]), rows[1:]
    if rows and (first := heading(rows[0])):
        names, rows = first, rows[1:]
    separator = next((s for s in _SEPARATORS if rows and s.encode() in rows[0]), None)
    if rows and b'"' in rows[0]:
        rows = _unquoted(rows, separator)
    if separator in (";", "\t") and rows and b"," in rows[0] and b"." not in rows[0]:
        rows = [row.replace(b",", b".") for row in rows]
    return _Table(names=names, rows=rows, separator=separator, claimed=claimed)


def _utf8(content: bytes) -> bytes:
    """Text in UTF-8; spreadsheets save it with a byte order mark, in 8 or 16 bits."""
    for mark, encoding in ((codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be")):
        if content.startswith(mark):
            return content[len(mark) :].decode(encoding, "replace").encode()
    return content.removeprefix(codecs.BOM_UTF8)


def _unquoted(rows: Sequence[bytes], separator: str | None) -> list[bytes]:
    """Rows without quotation marks and quoted separators."""
    mark = separator or " "
    cells = csv.reader((row.decode("latin-1") for row in rows), delimiter=mark)
    return [mark.join(cell.replace(mark, "_") for cell in row).encode("latin-1") for row in cells]


def names_points(path: Path) -> bool:
    """True if the first lines of a table name x, y and z, and no rotation."""
    with path.open("rb") as file:
        lines = [file.readline(_MAX_LINE_BYTES) for _ in range(_HEADER_LINES)]
    names = next((n for line in _utf8(b"".join(lines)).splitlines() if (n := heading(line))), ())
    return bool(names) and not _TURNS & {name.lower() for name in names}


def _values(found: _Table, names: tuple[str, ...] | None) -> tuple[NDArray[np.float64], set[int]]:
    """The numbers (N, K), and the indices of text columns in a table with names."""
    separator = found.separator
    if names is None or not found.rows:
        return parsed(found.rows, len(names) if names else None, separator), set()
    mark = None if separator is None else separator.encode()
    first = found.rows[0].split(mark)
    texts = {
        n
        for n, word in enumerate(first[: len(names)])
        if names[n].lower() not in XYZ and word.strip() and not _is_number(word)
    }
    rows: Sequence[bytes] = found.rows
    if texts:
        cut = [row.split(mark) for row in rows]
        rows = [(mark or b" ").join(w for n, w in enumerate(row) if n not in texts) for row in cut]
    return parsed(rows, len(names) - len(texts), separator), texts


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def names_by_kind(values: NDArray[np.float64]) -> tuple[str, ...]:
    """Names for columns without any: x y z, a single value, then triples by their range."""
    num = values.shape[1]
    if num < len(XYZ):
        raise InputError(f"a row has {num} values, but x, y and z are needed")
    if _are_opaque(values[:, len(XYZ) :]):
        return (*XYZ, *RGB, "alpha")
    names = [*XYZ, *(["intensity"] if num % 3 == 1 else [])]
    while num - len(names) >= len(XYZ):
        triple = values[:, len(names) : len(names) + 3]
        kind = next((k for k in _kinds(triple) if k[0] not in names), None)
        if kind is None:
            break
        names += kind
    return (*names, *(f"column_{n}" for n in range(len(names), num)))


def _are_opaque(rest: NDArray[np.float64]) -> bool:
    """True if four columns are colours with an alpha that is full in all rows."""
    if rest.shape[1] != 4 or len(rest) < 2 or not (rest >= 0.0).all():
        return False
    full = 1.0 if (rest <= 1.0).all() else 255.0
    return bool((rest[:, 3] == full).all() and (rest <= full).all())


def _kinds(triple: NDArray[np.float64]) -> list[tuple[str, ...]]:
    """Possible meanings of three columns: unit normals, or colours as bytes or shares."""
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(triple, axis=1)
    is_unit = ((np.abs(lengths - 1.0) < 0.01) | (lengths == 0.0)).all() and lengths.any()
    is_levels = bool((triple >= 0.0).all() and (triple <= 65535.0).all())
    is_levels &= bool((triple <= 1.0).all() or (triple == np.floor(triple)).all())
    kinds = [NORMAL] if is_unit and not (triple == np.floor(triple)).all() else []
    return [*kinds, *([RGB] if is_levels else []), *([NORMAL] if is_unit else [])]


def _typed(values: NDArray[np.float64], name: str, rows: Sequence[bytes]) -> NDArray[Any]:
    """Convert integers, so that colours as bytes are distinguished from shares."""
    has_point = bool(rows) and b"." in rows[0]
    is_share = has_point and values.max(initial=0.0) <= 1.0
    is_whole = np.abs(values) < 2**31
    if name.lower() in XYZ or is_share or not (is_whole & (values == np.floor(values))).all():
        return values
    return values.astype(np.int32)


def write(path: Path, columns: Columns) -> None:
    """Write a header of names and one row per point, every number with full precision."""
    write_parts(path, iter([columns]), len(columns["x"]))


def write_parts(path: Path, parts: Iterator[Columns], num: int) -> None:
    """Write columns in chunks."""
    mark = "," if path.suffix.lower() == ".csv" else " "
    with atomic_path(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        for number, columns in enumerate(parts):
            held = held_columns(as_words(columns, path), REAL, path)
            if number == 0:
                file.write(("" if mark == "," else "# ") + mark.join(held) + "\n")
            _write_rows(file, held, mark)


def write_pts(path: Path, columns: Columns) -> None:
    """Write the number of points, then x y z, intensity and colours, as Leica's programs do."""
    num = len(columns["x"])
    kept: Columns = {name: columns[name] for name in XYZ}
    kept["intensity"] = columns.get("intensity", np.zeros(num, np.int32))
    kept |= {name: columns[name] for name in RGB if name in columns}
    drop_columns([name for name in columns if name not in kept], path)
    with atomic_path(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        file.write(f"{num}\n")
        _write_rows(file, kept, " ")


def _write_rows(file: TextIO, columns: Columns, mark: str) -> None:
    for start in range(0, len(columns["x"]), _CHUNK_ROWS):
        parts = [values[start : start + _CHUNK_ROWS].tolist() for values in columns.values()]
        file.writelines(mark.join(map(repr, row)) + "\n" for row in zip(*parts, strict=True))


FORMAT: Format = table(read, write, options=frozenset({"columns"}), write_parts=write_parts)
PTS: Format = table(read, write_pts, options=frozenset({"columns"}))
