"""The rows of a PLY file, binary or text: columns of single values, and lists."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.columns import Columns
from recon.exports.numbers import parsed, whole
from recon.exports.plyheader import Element, Header, Property

Lists = dict[str, list[NDArray[Any]] | NDArray[Any]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """The rows of one element."""

    count: int
    columns: Columns
    lists: Lists
    """The list of each row: an array (N, K) if all have the same length."""


def read_rows(content: bytes, header: Header, names: set[str]) -> dict[str, Rows]:
    """The rows of the elements `names`; others are skipped.

    Raises
    ------
    InputError
        If fewer rows follow than the header claims, or a word is not a number.
    """
    source = _Text(content) if header.is_text else _Binary(content)
    wanted = [one.name for one in header.elements if one.name in names]
    found: dict[str, Rows] = {}
    for element in header.elements:
        if len(found) == len(wanted):
            break
        rows = source.rows(element)
        if element.name in names:
            found[element.name] = rows
    return found


def _check_count(element: Element, num_bytes: int, row_bytes: int) -> None:
    if num_bytes < element.count * row_bytes:
        raise InputError(
            f"{element.count} of {element.name} are claimed, but {num_bytes} bytes follow"
        )


class _Binary:
    """Rows parsed from bytes, one element after the other."""

    def __init__(self, content: bytes) -> None:
        self._content = content
        self._at = 0

    def rows(self, element: Element) -> Rows:
        _check_count(element, len(self._content) - self._at, element.min_row_bytes)
        if not element.has_lists or not element.count:
            table = np.frombuffer(self._content, element.row_dtype, element.count, self._at)
            self._at += table.nbytes
            return Rows(count=element.count, columns=_single(table, element), lists={})
        return self._of_one_length(element) or self._of_any_length(element)

    def _of_one_length(self, element: Element) -> Rows | None:
        """Read all rows at once if every list is as long as in the first row."""
        dtype = np.dtype(self._fields_of_first(element))
        if self._at + dtype.itemsize * element.count > len(self._content):
            return None
        table = np.frombuffer(self._content, dtype, element.count, self._at)
        lists = [one.name for one in element.properties if one.length_dtype]
        if any((table[f"{name} length"] != table[name].shape[1]).any() for name in lists):
            return None
        self._at += table.nbytes
        return Rows(
            count=element.count,
            columns=_single(table, element),
            lists={name: table[name] for name in lists},
        )

    def _fields_of_first(self, element: Element) -> list[Any]:
        fields: list[Any] = []
        at = self._at
        for one in element.properties:
            if one.length_dtype:
                length = self._value(one.length_dtype, at)
                fields.append((f"{one.name} length", one.length_dtype))
                at += np.dtype(one.length_dtype).itemsize
                fields.append((one.name, one.dtype, (length,)))
                at += length * np.dtype(one.dtype).itemsize
            else:
                fields.append((one.name, one.dtype))
                at += np.dtype(one.dtype).itemsize
        return fields

    def _value(self, dtype: str, at: int) -> int:
        """The length of a list, checked against the remaining data."""
        try:
            length = int(np.frombuffer(self._content, dtype, 1, at)[0])
        except ValueError as error:
            raise InputError("a list is cut short") from error
        if not 0 <= length <= len(self._content) - at:
            raise InputError(f"a list of {length} values is claimed, but the file ends before")
        return length

    def _of_any_length(self, element: Element) -> Rows:
        """Read row by row."""
        columns: dict[str, list[Any]] = {one.name: [] for one in element.properties}
        try:
            for _ in range(element.count):
                for one in element.properties:
                    columns[one.name].append(self._next(one))
        except struct.error as error:
            raise InputError(f"{element.name} is cut short") from error
        return _gathered(columns, element)

    def _next(self, one: Property) -> Any:
        if one.length_dtype is None:
            return self._unpacked(one.dtype, 1)[0]
        (length,) = self._unpacked(one.length_dtype, 1)
        if not 0 <= length <= len(self._content) - self._at:
            raise InputError(f"a list of {length} values is claimed, but the file ends before")
        return self._unpacked(one.dtype, int(length))

    def _unpacked(self, dtype: str, count: int) -> tuple[Any, ...]:
        kind = np.dtype(dtype)
        values = struct.unpack_from(f"{dtype[0]}{count}{kind.char}", self._content, self._at)
        self._at += count * kind.itemsize
        return values


class _Text:
    """Rows parsed from lines, one element after the other."""

    def __init__(self, content: bytes) -> None:
        self._lines = iter(line for line in content.splitlines() if line.strip())
        self._left = len(content)

    def rows(self, element: Element) -> Rows:
        # A row has at least a digit and a newline, which may be missing in the last line.
        _check_count(element, self._left + 1, 2)
        lines = list(self._take(element.count))
        if len(lines) < element.count:
            raise InputError(
                f"{element.count} of {element.name} are claimed, but {len(lines)} follow"
            )
        if element.has_lists:
            return self._with_lists(lines, element)
        names = [one.name for one in element.properties]
        table = parsed(lines, len(names))
        columns = {
            one.name: whole(table[:, n], one.dtype, one.name)
            for n, one in enumerate(element.properties)
        }
        return Rows(count=element.count, columns=columns, lists={})

    def _take(self, count: int) -> Iterator[bytes]:
        for _ in range(count):
            line = next(self._lines, None)
            if line is None:
                return
            yield line

    def _with_lists(self, lines: list[bytes], element: Element) -> Rows:
        columns: dict[str, list[Any]] = {one.name: [] for one in element.properties}
        for line in lines:
            words = parsed([line], None)[0]
            at = 0
            for one in element.properties:
                length = words[at] if one.length_dtype and at < len(words) else 1.0
                at += bool(one.length_dtype)
                # Written so that a length that is not a number fails.
                if not 0 <= length <= len(words) - at:
                    raise InputError(f"a row of {element.name} is {line[:60].decode('latin-1')!r}")
                values = words[at : at + int(length)]
                columns[one.name].append(values if one.length_dtype else values[0])
                at += int(length)
        return _gathered(columns, element)


def _single(table: NDArray[np.void], element: Element) -> Columns:
    return {one.name: table[one.name] for one in element.properties if not one.length_dtype}


def _gathered(columns: dict[str, list[Any]], element: Element) -> Rows:
    return Rows(
        count=element.count,
        columns={
            one.name: whole(np.array(columns[one.name], np.float64), one.dtype, one.name)
            for one in element.properties
            if not one.length_dtype
        },
        lists={
            one.name: [np.asarray(values) for values in columns[one.name]]
            for one in element.properties
            if one.length_dtype
        },
    )
