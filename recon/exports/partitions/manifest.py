"""The manifest of a partitioned map: the form of its cells, and the list of partitions."""

import json
from dataclasses import asdict, dataclass
from typing import Any

from recon.errors import InputError, check_number
from recon.exports.partitions.store import MANIFEST, Place, Store
from recon.files.documents import parse_json
from recon.voxelmap.coarse import MAX_LEVEL
from recon.voxelmap.sums import Key
from recon.voxelmap.table import MAX_INDEX
from recon.voxelmap.voxelmap import CHANNELS

VERSION = 1
MAX_BYTES = 1 << 28
COARSEST = 1 << MAX_LEVEL
"""Partition sides are multiples of the coarsest cell, so that it lies in one partition."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Form:
    """The form of the cells of a map."""

    cell_size: float
    """World units."""
    partition_size: int
    """Cells along a side of a partition."""
    channels: tuple[str, ...]
    ray_margin: float
    has_colour: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One partition."""

    index: Key
    """Index of the cube along x, y, z."""
    num_rows: int
    """Rows of its file: its cells, coarser ones, and those that rays only passed through."""
    num_cells: int
    """Cells with a point."""
    num_points: int
    """Points in these cells."""

    @property
    def file(self) -> str:
        """Name of its file."""
        return f"cells_{self.index[0]}_{self.index[1]}_{self.index[2]}.parquet"


@dataclass(frozen=True, slots=True, kw_only=True)
class Manifest:
    """Everything known about a partitioned map before a partition is read."""

    form: Form
    partitions: tuple[Entry, ...]
    """In index order."""

    def write(self, store: Store) -> None:
        """Write the manifest, which completes the map."""
        document = {"format": "recon partitions", "version": VERSION} | asdict(self.form)
        rows = ",\n".join(json.dumps(asdict(one)) for one in self.partitions)
        head = json.dumps(document, indent=1).removesuffix("\n}")
        store.write(MANIFEST, f'{head},\n "partitions": [\n{rows}\n]}}\n'.encode())


def read_manifest(store: Store, place: Place) -> Manifest:
    """The manifest of a partitioned map.

    Raises
    ------
    InputError
        If it is missing or invalid.
    """
    try:
        content = store.read(MANIFEST)
    except FileNotFoundError as error:
        raise InputError(f"{place} is not a whole partitioned map: no {MANIFEST}") from error
    if len(content) > MAX_BYTES:
        raise InputError(f"{place}: its {MANIFEST} has over {MAX_BYTES} bytes")
    try:
        return _parsed(parse_json(content.decode(), MANIFEST))
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{place}: its {MANIFEST} is damaged ({_said(error)})") from error


def _said(error: Exception) -> str:
    return f"no {error}" if isinstance(error, KeyError) else str(error)


def _parsed(document: dict[str, Any]) -> Manifest:
    if document["version"] != VERSION:
        raise InputError(f"version {document['version']!r}, but {VERSION} is needed")
    form = _form(document)
    farthest = MAX_INDEX // form.partition_size + 1
    entries = tuple(_entry(one, farthest) for one in document["partitions"])
    order = [one.index for one in entries]
    if order != sorted(set(order)):
        raise InputError("its partitions are not in order or not unique")
    return Manifest(form=form, partitions=entries)


def _form(document: dict[str, Any]) -> Form:
    cell_size, margin = document["cell_size"], document["ray_margin"]
    check_number("cell_size", cell_size, above=0)
    check_number("ray_margin", margin, low=0)
    side = _whole("partition_size", document["partition_size"], COARSEST, MAX_INDEX)
    if side % COARSEST:
        raise InputError(f"partition_size is {side}, but a multiple of {COARSEST} is needed")
    channels = document["channels"]
    if channels != sorted({one for one in channels if one in CHANNELS}):
        raise InputError(f"channels are {channels!r}, but some of {', '.join(CHANNELS)} are needed")
    return Form(
        cell_size=float(cell_size),
        partition_size=side,
        channels=tuple(channels),
        ray_margin=float(margin),
        has_colour=bool(document.get("has_colour", True)),
    )


def _entry(document: dict[str, Any], farthest: int) -> Entry:
    x, y, z = (_whole("index", value, -farthest, farthest) for value in document["index"])
    names = ("num_rows", "num_cells", "num_points")
    return Entry(index=(x, y, z), **{n: _whole(n, document[n], 0, 1 << 62) for n in names})


def _whole(name: str, value: object, low: int, high: int) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise InputError(f"{name} is {value!r}, but a whole number >= {low} is needed")
    return value
