"""Points as LAS or LAZ (ASPRS), by laspy: z up, every other value as its own dimension."""

from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError, one_line
from recon.exports.columns import RGB, XYZ, Columns
from recon.exports.format import Format, table
from recon.exports.lasheader import check_header
from recon.exports.names import spelled
from recon.exports.numbers import REAL, held_columns
from recon.files import atomic_path
from recon.libraries import load_extra, silent
from recon.records import Crs

# LAS stores coordinates as 32-bit integers: as fine as the extent allows, in powers of ten.
_FINEST_STEP = 1e-7
_MAX_STEPS = 2**31 - 1

# 8 bits as 16: 255 becomes 65535.
_COLOUR_FACTOR = 257

_MAX_NAME_BYTES = 32

# Suffix of a column whose name is a LAS dimension, but whose values do not fit it.
_BESIDE = "_value"

_CRS_USER = "LASF_Projection"
_CRS_NUMBERS = (2112, 34735, 34736, 34737)
_WKT = 2112


def write(path: Path, columns: Columns, crs: Crs | None) -> None:
    """Write columns; coordinates are rounded to steps of a power of ten, at least 1e-7."""
    laspy = load_extra("laspy", "las")
    own = XYZ + RGB if set(RGB) <= columns.keys() else XYZ
    extra = {name: v for name, v in columns.items() if name not in own}
    kept = spelled(held_columns(extra, REAL, path), _dimension_name, path)
    header, names = _header(laspy, columns, kept, crs)
    file = laspy.LasData(header)
    for name in XYZ:
        file[name] = columns[name]
    for name in own[len(XYZ) :]:
        file[name] = columns[name].astype(np.uint16) * _COLOUR_FACTOR
    for name, values in kept.items():
        file[names[name]] = values
    with atomic_path(path) as temporary:
        file.write(str(temporary))


def _dimension_name(name: str) -> str:
    return name if len(name.encode()) <= _MAX_NAME_BYTES else ""


def _header(
    laspy: Any, columns: Columns, held: Columns, crs: Crs | None
) -> tuple[Any, dict[str, str]]:
    """The header, and the dimension of each column."""
    # Format 7 is format 6 with colours.
    kind = 7 if set(RGB) <= columns.keys() else 6
    header = laspy.LasHeader(point_format=kind, version="1.4")
    low = np.array([columns[name].min(initial=np.inf) for name in XYZ])
    high = np.array([columns[name].max(initial=-np.inf) for name in XYZ])
    if len(columns["x"]):
        header.offsets = np.floor(low)
        steps = (high - header.offsets) / _MAX_STEPS
        header.scales = 10.0 ** np.ceil(np.log10(np.maximum(steps, _FINEST_STEP)))
    own = {dimension.name: dimension for dimension in header.point_format.dimensions}
    names = {name: name for name in held}
    for name, values in held.items():
        if name not in own or not _fits(values, own[name]):
            names[name] = name + _BESIDE if name in own else name
            header.add_extra_dim(laspy.ExtraBytesParams(name=names[name], type=values.dtype))
    for number, content in crs.records if crs else ():
        header.vlrs.append(laspy.VLR(_CRS_USER, number, record_data=content))
        header.global_encoding.wkt |= number == _WKT
    return header, names


def _fits(values: Any, dimension: Any) -> bool:
    """True if a standard LAS dimension can hold the values."""
    whole = values.dtype.kind in "iub" or bool((values == np.floor(values)).all())
    if dimension.kind.name == "FloatingPoint":
        return True
    return whole and bool((values >= dimension.min).all() and (values <= dimension.max).all())


def read(path: Path) -> tuple[Columns, Crs | None]:
    """Coordinates, colours if there are any, all other dimensions, and the reference system.

    Raises
    ------
    InputError
        If the header does not fit the file, or the points cannot be decompressed.
    """
    laspy = load_extra("laspy", "las")
    check_header(path)
    try:
        with silent():
            file = laspy.read(str(path))
    except Exception as error:
        raise InputError(f"not a whole LAS file ({one_line(error)})") from error
    except BaseException as error:
        # A panic of the Rust part is not an Exception.
        if type(error).__name__ != "PanicException":
            raise
        raise InputError("not a whole LAZ file (its points cannot be unpacked)") from error
    return _columns(file), _crs(file)


def _columns(file: Any) -> Columns:
    """Coordinates and dimensions; standard LAS dimensions only if not all 0."""
    with np.errstate(over="ignore"):  # non-finite points are left out later
        columns = {name: np.asarray(file[name], dtype=np.float64) for name in XYZ}
    extra = set(file.point_format.extra_dimension_names)
    if "" in extra:
        raise InputError("not a valid LAS file (one of its extra dimensions has no name)")
    for name in file.point_format.dimension_names:
        values = np.asarray(file[name])
        if values.ndim == 2:
            columns |= {f"{name}_{n}": column for n, column in enumerate(values.T)}
        elif name not in ("X", "Y", "Z") and (name in (*RGB, *extra) or values.any()):
            columns[name] = values
    for name in [name for name in columns if name.endswith(_BESIDE)]:
        own = name.removesuffix(_BESIDE)
        if own not in columns:
            columns[own] = columns.pop(name)
    return columns


def _crs(file: Any) -> Crs | None:
    records = tuple(
        (record.record_id, bytes(record.record_data_bytes()))
        for record in [*file.header.vlrs, *(file.header.evlrs or ())]
        if record.user_id == _CRS_USER and record.record_id in _CRS_NUMBERS
    )
    return Crs(records=records) if records else None


FORMAT: Format = table(read, write, up="z", keeps_crs=True)
