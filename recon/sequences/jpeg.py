"""Truncated JPEG files with a valid end, which decoders silently fill with grey."""

import re

import numpy as np
from numpy.typing import NDArray

PROBE = b"\x55" * 64
"""Additional entropy-coded bits: complete images ignore them, truncated ones decode them."""
FILLED = 128
"""The grey level of undecoded blocks."""

_SCAN, _END = 0xDA, 0xD9
_MARKER = re.compile(rb"\xff[^\x00\xd0-\xd7\xff]")
_PROGRESSIVE = 0xC2


def has_all_parts(data: bytes) -> bool:
    """True if the segments of a file lead to its end, and no progressive scan is missing."""
    markers = _markers(data)
    if not any(kind == _END for kind, _ in markers):
        return False
    if not any(kind == _PROGRESSIVE for kind, _ in markers):
        return True
    finished = np.zeros((256, 64), np.bool_)
    scanned = np.zeros(256, np.bool_)
    for at in (at for kind, at in markers if kind == _SCAN):
        number = data[at + 4]
        components = [*data[at + 5 : at + 5 + 2 * number : 2]]
        first, last, bits = data[at + 5 + 2 * number : at + 8 + 2 * number]
        scanned[components] = True
        if bits & 15 == 0:  # the last bit of these coefficients
            finished[components, first : last + 1] = True
    return bool(finished[scanned].all())


def may_be_cut(data: bytes, pixels: NDArray[np.generic]) -> bool:
    """True if a decoded image (H, W, ...) ends like a truncated one, or is progressive."""
    is_filled = bool((pixels[-8:, -8:] == FILLED).all())
    return is_filled or any(kind == _PROGRESSIVE for kind, _ in _markers(data))


def probed(data: bytes) -> bytes:
    """The file with additional bits before its end, which change its pixels if some are missing."""
    end = next((at for kind, at in _markers(data) if kind == _END), len(data))
    return data[:end] + PROBE + data[end:]


def _markers(data: bytes) -> list[tuple[int, int]]:
    """(kind, position) of the markers of a file, up to its end."""
    found, at = [], 2
    while (marker := _MARKER.search(data, at)) is not None:
        kind, at = data[marker.start() + 1], marker.start()
        found.append((kind, at))
        if kind == _END:
            break
        # The data of a scan follow its header, and are skipped by the search.
        at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return found
