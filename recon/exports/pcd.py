"""Points as PCD (Point Cloud Library), by pypcd4: every value as a named field."""

import io
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exports.columns import Columns
from recon.exports.format import Format, table
from recon.exports.names import as_words
from recon.exports.numbers import held_columns, parsed, whole
from recon.exports.pcdheader import HELD, Header, parse_header
from recon.files import atomic_path, check_memory

_PADDING = "_"


def write(path: Path, columns: Columns) -> None:
    """Write columns as fields, binary."""
    import pypcd4

    held = held_columns(as_words(columns, path), HELD, path)
    arrays = [np.ascontiguousarray(values) for values in held.values()]
    cloud = pypcd4.PointCloud.from_points(arrays, list(held), [one.dtype for one in arrays])
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        cloud.save(file, encoding=pypcd4.Encoding.BINARY)


def read(path: Path) -> Columns:
    """The fields of the points; padding is ignored.

    Raises
    ------
    InputError
        If the file has fewer points than it claims, or words that are not numbers.
    """
    content = path.read_bytes()
    header, start = parse_header(content)
    check_memory(path, 3.0 * max(len(content), header.num_points * header.point_bytes))
    body = content[start:]
    if header.layout == "ascii":
        return _from_text(header, body)
    _check_size(header, body)
    return _from_bytes(header, body)


def _from_text(header: Header, body: bytes) -> Columns:
    lines = [line for line in body.splitlines() if line.strip() and not line.startswith(b"#")]
    if len(lines) < header.num_points:
        raise InputError(f"{header.num_points} points are claimed, but {len(lines)} follow")
    values = parsed(lines[: header.num_points], header.num_values)
    columns: Columns = {}
    at = 0
    for name, code, count in zip(header.names, header.dtypes, header.counts, strict=True):
        for number in range(count):
            if name != _PADDING:
                columns[_numbered(name, number, count)] = whole(values[:, at], code, name)
            at += 1
    return columns


def _check_size(header: Header, body: bytes) -> None:
    claimed = header.num_points * header.point_bytes
    if header.layout == "binary":
        if len(body) < claimed:
            raise InputError(
                f"{header.num_points} points are claimed, but {len(body)} bytes follow"
            )
        return
    packed, unpacked = (int(size) for size in np.frombuffer(body[:8].ljust(8, b"\0"), "<u4"))
    if unpacked != claimed or packed > len(body) - 8:
        raise InputError(
            f"{header.num_points} points are claimed, but {min(packed, len(body) - 8)} bytes of "
            f"{packed} follow for {unpacked}"
        )


def _from_bytes(header: Header, body: bytes) -> Columns:
    """Parse the points with pypcd4, under a header in the only form it supports."""
    import pypcd4

    names = [f"field{number}" for number in range(len(header.names))]
    lines = {
        "VERSION": ["0.7"], "FIELDS": names, "SIZE": [code[2:] for code in header.dtypes],
        "TYPE": [code[1].upper() for code in header.dtypes], "COUNT": header.counts,
        "WIDTH": [header.width], "HEIGHT": [header.height], "VIEWPOINT": [0, 0, 0, 1, 0, 0, 0],
        "POINTS": [header.num_points], "DATA": [header.layout],
    }  # fmt: skip
    text = "".join(f"{key} {' '.join(map(str, words))}\n" for key, words in lines.items())
    file: Any = io.BytesIO(text.encode() + body)
    try:
        points = pypcd4.PointCloud.from_fileobj(file).pc_data
    except (ValueError, RuntimeError, TypeError) as error:
        raise InputError(f"not a whole PCD file ({error})") from error
    columns: Columns = {}
    for field, name, count in zip(names, header.names, header.counts, strict=True):
        for number in range(count if name != _PADDING else 0):
            stored = field if count == 1 else f"{field}__{number:04d}"
            columns[_numbered(name, number, count)] = points[stored]
    return columns


def _numbered(name: str, number: int, count: int) -> str:
    """The name of one value of a field."""
    return name if count == 1 else f"{name}_{number}"


FORMAT: Format = table(read, write)
