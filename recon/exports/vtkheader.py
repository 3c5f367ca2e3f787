"""Headers of VTK files, checked against their content, since VTK trusts them."""

import base64
import re
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.files import check_memory

_COPIES = 10.0

# Counts claimed by a legacy file; each takes at least one byte.
_LEGACY = re.compile(rb"(?m)^\s*(POINTS|CELLS|POINT_DATA|CELL_DATA|LINES|POLYGONS)\s+(\d+)", re.I)
_XML = re.compile(rb"NumberOf(?:Points|Cells|Polys|Verts)=\"(\d+)\"")
_DIMENSIONS = re.compile(rb"(?m)^\s*DIMENSIONS\s+(\d+)\s+(\d+)\s+(\d+)", re.I)

# Arrays in an XML file: after their tag, or at an offset in the appended data.
_ARRAY = re.compile(rb"<(?:DataArray|Array)\b([^>]*)>", re.S)
_OFFSET = re.compile(rb"\boffset=\"(\d+)\"")
_APPENDED = re.compile(rb"<AppendedData[^>]*encoding=\"(raw|base64)\"[^>]*>\s*_")
_HEAD_WORDS = 3
"""Header words of a packed array: number of blocks, their size, the last one's size."""


def check_claims(content: bytes, path: Path) -> None:
    """Raise `InputError` if a file is not a VTK file, or claims more than it can hold."""
    if content.startswith(b"# vtk DataFile"):
        _check_legacy(content)
    elif b"<VTKFile" not in content[:1000]:
        raise InputError("not a VTK file")
    elif not content.rstrip().endswith(b"</VTKFile>"):
        raise InputError("not a whole VTK file")
    else:
        _check_arrays(content, path)
    for match in _DIMENSIONS.finditer(content[:10_000]):
        check_memory(path, _COPIES * float(np.prod([float(word) for word in match.groups()])))
    for match in _XML.finditer(content):
        check_memory(path, _COPIES * 12.0 * float(match[1]))


def _check_legacy(content: bytes) -> None:
    claims = [int(match[2]) for match in _LEGACY.finditer(content)]
    if max(claims, default=0) > len(content):
        raise InputError(f"{max(claims)} are claimed, but the file has {len(content)} bytes")


def _check_arrays(content: bytes, path: Path) -> None:
    """Check the header of every binary array against the file and the memory limit."""
    head = content[: content.find(b">", content.find(b"<VTKFile"))]
    is_packed, is_wide = b"compressor=" in head, b"UInt64" in head
    form = f"{'>' if b'BigEndian' in head else '<'}{_HEAD_WORDS}{'Q' if is_wide else 'I'}"
    unpacked = 0
    for start in _heads(content, struct.calcsize(form)):
        if len(start) < struct.calcsize(form):
            continue
        num, block, last = struct.unpack(form, start)
        num_bytes = (num - 1 if last else num) * block + last if is_packed and num else num
        if (num if is_packed else num_bytes) > len(content):
            raise InputError(
                f"an array claims {num} blocks or bytes, but {len(content)} bytes follow"
            )
        unpacked += num_bytes
    check_memory(path, 2.0 * unpacked)


def _heads(content: bytes, num_bytes: int) -> Iterator[bytes]:
    """The first bytes of the binary arrays."""
    num_chars = -(-num_bytes // 3) * 4
    appended = _APPENDED.search(content)
    for array in _ARRAY.finditer(content[: appended.start()] if appended else content):
        offset = _OFFSET.search(array[1])
        if b"appended" in array[1] and offset and appended:
            begin = appended.end() + int(offset[1])
            is_raw = appended[1] == b"raw"
            start = content[begin : begin + (num_bytes if is_raw else num_chars)]
            yield start if is_raw else _decoded(start)[:num_bytes]
        elif b"binary" in array[1]:
            text = content[array.end() : array.end() + 200].lstrip()
            yield _decoded(text[:num_chars])[:num_bytes]


def _decoded(text: bytes) -> bytes:
    try:
        return base64.b64decode(text)
    except ValueError:
        return b""
