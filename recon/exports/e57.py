"""Points from E57 (ASTM), by pye57: z up, all scans of a file in its common frame."""

import struct
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError, one_line
from recon.exports.columns import RGB, XYZ, Columns
from recon.exports.format import Format, table
from recon.files import check_memory
from recon.libraries import load_extra

_FIELDS = {
    "cartesianX": "x", "cartesianY": "y", "cartesianZ": "z", "colorRed": "red",
    "colorGreen": "green", "colorBlue": "blue", "intensity": "intensity", "rowIndex": "row",
    "columnIndex": "column", "timeStamp": "time",
}  # fmt: skip
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
_HEADER = struct.Struct("<8sIIQQQQ")


def read(path: Path) -> Columns:
    """The points of all scans in the common frame; values missing in some scans are NaN there.

    Raises
    ------
    InputError
        If the file is truncated or contains no scan.
    """
    pye57 = load_extra("pye57", "e57")
    _check_header(path)
    try:
        file = pye57.E57(str(path))
        headers = [file.get_header(n) for n in range(file.scan_count)]
        check_memory(path, 200.0 * sum(one.point_count for one in headers))
        scans = [_scan(file, n, one) for n, one in enumerate(headers)]
    except InputError:
        raise
    # The library's C++ part raises errors without a common base class.
    except Exception as error:
        raise InputError(f"not a whole E57 file ({one_line(error)})") from error
    if not scans:
        raise InputError("it holds no scan")
    return _joined(scans)


def _check_header(path: Path) -> None:
    with path.open("rb") as file:
        head = file.read(_HEADER.size)
    if len(head) < _HEADER.size or head[:8] != b"ASTM-E57":
        raise InputError("not an E57 file (wrong signature)")
    _, _, _, claimed, xml_start, xml_bytes, page = _HEADER.unpack(head)
    size = path.stat().st_size
    if claimed > size or xml_start + xml_bytes > size or page != 1024:
        raise InputError(f"{claimed} bytes are claimed, but the file has {size}")


def _scan(file: Any, number: int, header: Any) -> Columns:
    raw = file.read_scan_raw(number)
    fields = {str(name): np.asarray(values) for name, values in raw.items()}
    invalid = next((fields[n] for n in fields if n.endswith("InvalidState")), None)
    if set(_SPHERICAL) <= fields.keys():
        fields |= _cartesian(*(fields[name] for name in _SPHERICAL))
    columns = {ours: fields[name] for name, ours in _FIELDS.items() if name in fields}
    places = np.column_stack([columns[name] for name in XYZ]).astype(np.float64)
    if header.has_pose():
        places = places @ np.asarray(header.rotation_matrix).T + np.asarray(header.translation)
    if invalid is not None:
        places[invalid != 0] = np.nan
    columns |= zip(XYZ, places.T, strict=True)
    for name in RGB:
        if name in columns:
            columns[name] = columns[name].astype(np.uint16)
    return columns


def _cartesian(reach: Any, azimuth: Any, elevation: Any) -> Columns:
    flat = reach * np.cos(elevation)
    return {
        "cartesianX": flat * np.cos(azimuth),
        "cartesianY": flat * np.sin(azimuth),
        "cartesianZ": reach * np.sin(elevation),
    }


def _joined(scans: list[Columns]) -> Columns:
    names = list(dict.fromkeys(name for scan in scans for name in scan))
    colourless = [name for name in RGB if not all(name in scan for scan in scans)]
    return {
        name: np.concatenate([scan.get(name, np.full(len(scan["x"]), np.nan)) for scan in scans])
        for name in names
        if name not in colourless
    }


FORMAT: Format = table(read, None, up="z")
