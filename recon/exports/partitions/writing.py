"""Writing of partitioned maps, from a map in memory or as the sum of partitioned maps."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from recon.errors import InputError
from recon.exports.partitions.manifest import COARSEST, Entry, Form, Manifest
from recon.exports.partitions.partitioned import PartitionedMap, summary
from recon.exports.partitions.rows import to_parquet
from recon.exports.partitions.store import MANIFEST, Place, Store, store_of
from recon.libraries import memory_kept
from recon.notices import notify
from recon.threads import in_threads
from recon.voxelmap import VoxelMap
from recon.voxelmap.summed import sums_of
from recon.voxelmap.sums import CellSums, Key, added, split

PARTITION_SIZE = 256
"""Default number of cells along a side of a partition."""
_Share = tuple[PartitionedMap, Entry, int]
"""A partition of one map, and the offset of its view numbers."""


def write_partitions(
    voxel_map: VoxelMap, place: Place, partition_size: int = PARTITION_SIZE
) -> PartitionedMap:
    """Write a map as a folder of partitions; the same map yields the same bytes.

    Parameters
    ----------
    place : path or URL
        The folder; an existing partitioned map is replaced.
    partition_size : int
        Cells along a side, a multiple of 64.
    """
    if partition_size < COARSEST or partition_size % COARSEST:
        raise InputError(
            f"partition_size is {partition_size}, but a multiple of {COARSEST} is needed"
        )
    form = Form(
        cell_size=voxel_map.cell_size,
        partition_size=partition_size,
        channels=voxel_map.channels,
        ray_margin=voxel_map.ray_margin,
        has_colour=voxel_map.has_colour,
    )
    store, parts = store_of(place), split(sums_of(voxel_map), partition_size)
    _complete((_written(store, form, key, cells) for key, cells in parts), form, store)
    return PartitionedMap(place)


def merge_partitions(
    sources: Sequence[PartitionedMap], place: Place, first_views: Sequence[int] | None = None
) -> PartitionedMap:
    """Write the sum of some maps, partition by partition; the order of the maps does not matter.

    Memory holds at most the cells of one partition of all maps per thread.

    Parameters
    ----------
    sources : sequence of PartitionedMap
        At least one, all of the same form.
    place : path or URL
        The folder to write.
    first_views : sequence of int, optional
        Offset added to the view numbers of each map, so that views of different recordings stay
        distinct.

    Raises
    ------
    InputError
        If the maps are of different forms.
    """
    form = _common_form(sources)
    first = [0] * len(sources) if first_views is None else first_views
    held: dict[Key, list[_Share]] = {}
    for source, view in zip(sources, first, strict=True):
        for entry in source.partitions:
            held.setdefault(entry.index, []).append((source, entry, view))

    store = store_of(place)

    def merged(key: Key) -> Entry:
        shares = (_renumbered(one.sums(entry), view) for one, entry, view in held[key])
        if not form.has_colour:
            shares = (cells.without_colour() for cells in shares)
        return _written(store, form, key, added(shares))

    with memory_kept():
        _complete(in_threads(merged, sorted(held)), form, store)
    return PartitionedMap(place)


def _common_form(sources: Sequence[PartitionedMap]) -> Form:
    """The form of all maps; without colours if one of them has none."""
    has_colour = all(source.form.has_colour for source in sources)
    forms = [replace(source.form, has_colour=has_colour) for source in sources]
    for source, form in zip(sources, forms, strict=True):
        if form != forms[0]:
            raise InputError(
                f"{source.place} has {form}, but {forms[0]} is needed, as of {sources[0].place}"
            )
    if not has_colour and any(source.form.has_colour for source in sources):
        notify("colour-missing", "a map without colours is merged: the sum has no colours")
    return forms[0]


def _renumbered(cells: CellSums, first_view: int) -> CellSums:
    if not first_view:
        return cells
    step = np.array([[0], [0], [0], [first_view]], np.int32)
    return replace(cells, views=cells.views + step)


def _written(store: Store, form: Form, key: Key, cells: CellSums) -> Entry:
    """The entry of a partition whose file is written."""
    entry = summary(key, cells)
    store.write(entry.file, to_parquet(cells, keeps_views="views" in form.channels))
    return entry


def _complete(written: Iterable[Entry], form: Form, store: Store) -> None:
    """Let the partitions be written, and the manifest last, which completes the map."""
    store.remove(MANIFEST)
    entries = tuple(written)
    known = {entry.file for entry in entries}
    for name in store.names():
        if name.startswith("cells_") and name not in known:
            store.remove(name)
    Manifest(form=form, partitions=entries).write(store)
