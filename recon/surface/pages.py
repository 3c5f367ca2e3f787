"""Tables of cells, one per region of space; those out of use are on disk."""

import re
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.voxelmap.archive import read_array
from recon.voxelmap.table import CellTable, Rows, in_order, order_of

Key = tuple[int, int, int]

HELD_BYTES = 256 << 20
"""Maximum size of the pages in memory, besides the one in use."""
_REGION = np.dtype([("index", np.int32, (3,))])
_NEIGHBOURS = tuple(product((-1, 0, 1), repeat=3))


class Pages:
    """The cells of a grid in cubic regions, a table each.

    Parameters
    ----------
    dtype : np.dtype
        Of a cell; its field `index` (3,) int32 names it.
    side : int
        Cells along each side of a region.
    folder : Path, optional
        Folder for pages out of use, which bounds memory; all stay in memory if None.
    """

    def __init__(self, dtype: "np.dtype[np.void]", side: int, folder: Path | None = None) -> None:
        self.dtype = dtype
        self.side = side
        self.folder = folder
        self._held: dict[Key, CellTable] = {}
        """Pages in memory, least recently used first."""
        self._stored: dict[Key, int] = {}
        """Pages on disk, with their number of cells."""

    @property
    def keys(self) -> list[Key]:
        """The regions with a page, in order."""
        return sorted(self._held.keys() | self._stored)

    @property
    def num_cells(self) -> int:
        """Number of cells of all regions."""
        held = {key: table.num_rows for key, table in self._held.items()}
        return sum((self._stored | held).values())

    def page(self, key: Key) -> CellTable:
        """The cells of a region; they may be changed until the next page is requested."""
        self._put_aside()
        table = self._held.pop(key, None)
        if table is None:
            table = self._read(key) if key in self._stored else CellTable(self.dtype)
        self._held[key] = table
        return table

    def __iter__(self) -> Iterator[Rows]:
        """Yield the cells of each region, in an order independent of their arrival."""
        for key in self.keys:
            yield in_order(self.page(key).used)

    def around(self, key: Key, margin: int) -> CellTable:
        """The cells of a region and of its neighbours, up to `margin` cells away."""
        corner = self.side * np.array(key)
        chosen = [np.zeros(0, self.dtype)]
        for step in _NEIGHBOURS:
            neighbour = (key[0] + step[0], key[1] + step[1], key[2] + step[2])
            if neighbour in self._held or neighbour in self._stored:
                rows = self.page(neighbour).used
                away = rows["index"] - corner
                near = (away >= -margin) & (away < self.side + margin)
                chosen.append(rows[near.all(axis=1)])
        return CellTable.of(np.concatenate(chosen))

    def save(self, folder: Path) -> None:
        """Write every page to a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for key, rows in zip(self.keys, self, strict=True):
            np.save(folder / _name_of(key), rows)

    def _put_aside(self) -> None:
        """Move pages to disk until the others fit into memory."""
        if self.folder is None:
            return
        num_bytes = sum(table.nbytes for table in self._held.values())
        while num_bytes > HELD_BYTES:
            key = next(iter(self._held))
            table = self._held.pop(key)
            num_bytes -= table.nbytes
            self.folder.mkdir(parents=True, exist_ok=True)
            np.save(self.folder / _name_of(key), table.used)
            self._stored[key] = table.num_rows

    def _read(self, key: Key) -> CellTable:
        assert self.folder is not None
        return CellTable.of(read_page(self.folder / _name_of(key), self.dtype))


def saved_keys(folder: Path) -> list[Key]:
    """The regions with a page in a folder, in order."""
    return sorted(_key_of(path) for path in folder.glob("*.npy"))


def read_page(path: Path, dtype: "np.dtype[np.void]") -> Rows:
    """The cells of a page's file.

    Raises
    ------
    InputError
        For a truncated file, or one with other content.
    """
    rows = read_array(path)
    if rows.dtype != dtype or rows.ndim != 1:
        raise InputError(f"{path} holds {rows.dtype} {rows.shape}, but cells of a page are needed")
    return rows


def page_path(folder: Path, key: Key) -> Path:
    """The file of a region's page."""
    return folder / _name_of(key)


def regions_of(index: NDArray[np.integer], side: int) -> Iterator[tuple[Key, NDArray[np.int64]]]:
    """The regions of cells (N, 3), with the rows (K,) of the cells in each, in order."""
    table = CellTable(_REGION)
    number = table.enter(index // side)
    rank = np.empty(table.num_rows, np.int64)
    keys = order_of(table.used["index"])
    rank[keys] = np.arange(len(keys))
    # Sorting is linear for numbers of 16 bits.
    short = np.uint16 if len(keys) < 1 << 16 else np.int64
    order = np.argsort(rank.astype(short)[number], kind="stable")
    firsts = np.bincount(number, minlength=len(keys))[keys].cumsum()[:-1]
    found = table.used["index"][keys].tolist()
    for key, rows in zip(found, np.split(order, firsts), strict=False):
        yield (key[0], key[1], key[2]), rows


def _name_of(key: Key) -> str:
    return "_".join(map(str, key)) + ".npy"


def _key_of(path: Path) -> Key:
    words = re.fullmatch(r"(-?\d+)_(-?\d+)_(-?\d+)", path.stem)
    if not words:
        raise InputError(f"{path} is not a page of a region: its name is not x_y_z.npy")
    x, y, z = map(int, words.groups())
    return x, y, z
