"""Points as LAS or LAZ (ASPRS), by laspy: z up, every other value an extra dimension."""

from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exports.columns import RGB, XYZ, Columns
from recon.files import atomic_path
from recon.libraries import load_extra

# LAS keeps places as whole steps in 32 bits: as fine as the extent allows, by powers of ten.
_FINEST_STEP = 1e-7
_MAX_STEPS = 2**31 - 1

# 8 bits as 16: 255 becomes 65535.
_COLOUR_FACTOR = 257


def write(path: Path, columns: Columns) -> None:
    """Write columns; places are rounded to steps of a power of ten, from 1e-7 on."""
    laspy = load_extra("laspy", "las")
    file = laspy.LasData(_header(laspy, columns))
    for name in XYZ:
        file[name] = columns[name]
    for name in RGB:
        file[name] = columns[name].astype(np.uint16) * _COLOUR_FACTOR
    for name in _extra(columns):
        file[name] = columns[name]
    with atomic_path(path) as temporary:
        file.write(str(temporary))


def _header(laspy: Any, columns: Columns) -> Any:
    header = laspy.LasHeader(point_format=7, version="1.4")
    low = np.array([columns[name].min(initial=np.inf) for name in XYZ])
    high = np.array([columns[name].max(initial=-np.inf) for name in XYZ])
    if len(columns["x"]):
        header.offsets = np.floor(low)
        steps = (high - header.offsets) / _MAX_STEPS
        header.scales = 10.0 ** np.ceil(np.log10(np.maximum(steps, _FINEST_STEP)))
    for name in _extra(columns):
        header.add_extra_dim(laspy.ExtraBytesParams(name=name, type=columns[name].dtype))
    return header


def _extra(columns: Columns) -> list[str]:
    return [name for name in columns if name not in XYZ + RGB]


def read(path: Path) -> Columns:
    """The places, the colours where there are any, and the extra dimensions."""
    laspy = load_extra("laspy", "las")
    try:
        file = laspy.read(str(path))
    except (laspy.errors.LaspyException, ValueError, EOFError, RuntimeError) as error:
        raise InputError(f"{path}: not a whole LAS file ({error})") from error
    columns = {name: np.asarray(file[name], dtype=np.float64) for name in XYZ}
    if set(RGB) <= set(file.point_format.dimension_names):
        wide = {name: np.asarray(file[name]) for name in RGB}
        # Some writers put 8 bits into the 16 without widening them.
        factor = _COLOUR_FACTOR if max(c.max(initial=0) for c in wide.values()) > 255 else 1
        columns |= {name: (values // factor).astype(np.uint8) for name, values in wide.items()}
    for name in file.point_format.extra_dimension_names:
        columns[name] = np.asarray(file[name])
    return columns
