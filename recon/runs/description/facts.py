"""Facts by name, and those common to many kinds."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Facts = dict[str, Any]
"""Facts by name: words, numbers, lists of them, and tables as lists of mappings."""


def extent(points: NDArray[Any]) -> Facts:
    """Low and high corner of points (N, 3); empty without points."""
    if not len(points):
        return {}
    return {"low": points.min(axis=0).tolist(), "high": points.max(axis=0).tolist()}


def spread(name: str, values: NDArray[Any]) -> Facts:
    """Minimum, median and maximum of the known values."""
    known = values[np.isfinite(values)]
    if not known.size:
        return {name: None}
    numbers = (known.min(), np.median(known), known.max())
    return {name: dict(zip(("lowest", "median", "highest"), map(float, numbers), strict=True))}


def table(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> list[dict[str, Any]]:
    """Some columns of rows; missing values are null."""
    return [{name: row.get(name) for name in names} for row in rows]
