"""Occupancy of the floor, with names (thesis figures 30 to 32) and without."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import floor, footprints, names, scales
from recon.figures.canvas import ACCENT, FAINT, INK, SERIES, Sheet, Size
from recon.figures.cover import Cover
from recon.figures.map3d import UNITS
from recon.figures.partition import cells_of
from recon.records import UNKNOWN, FoundObject, GroundGrid, Voxels
from recon.voxelmap import ground

Array = NDArray[np.float64]
SIZE: Size = (1000, 860)

STATES = {ground.UNKNOWN: "#dfe3e6", ground.FREE: "#ffffff", ground.OCCUPIED: "#4a4f55"}
WAY = "#9aa1a8"
OCCUPIED = STATES[ground.OCCUPIED]


def occupancy(voxels: Voxels, *, unit: str = UNITS, sheet: Sheet | None = None) -> Any:
    """Points over every floor cell, summed over height (thesis section 4.4)."""
    sheet = sheet or Sheet.of(SIZE, fits=True)
    axes = floor.floor_axes(sheet, "Occupancy: points summed over height", unit)
    floor.show(axes, floor.extent_of(voxels))
    if not len(voxels):
        return sheet.figure
    grid = ground.height_sum(voxels)
    sums = grid.cells.astype(np.float64)
    seen = sums[sums > 0]
    scale = scales.coloured(seen, scales.COUNT + "_r", is_log=True)
    shown = np.ma.masked_less_equal(sums, 0)
    drawn = floor.draw_grid(axes, grid, shown, cmap=scale.cmap, norm=scale.norm)
    low, high = scale.get_clim()
    bar = sheet.colour_bar(
        drawn, axes, "points per floor cell", extend=scales.beyond(seen, low, high)
    )
    scales.plain_numbers(bar)
    sheet.fit(axes)
    floor.add_scale_bar(sheet, axes, unit)
    return sheet.figure


def labels(
    voxels: Voxels,
    objects: Sequence[FoundObject] = (),
    *,
    trajectory: Array | None = None,
    states: GroundGrid | None = None,
    unit: str = UNITS,
    with_legend: bool = True,
    sheet: Sheet | None = None,
) -> Any:
    """The floor with the footprint, name and probability of every object.

    Parameters
    ----------
    voxels : Voxels
        Occupied cells.
    objects : sequence of FoundObject
    trajectory : (N, 4, 4), optional
        `T_world_left` of every pair; north is the direction of the first one.
    states : GroundGrid, optional
        Free, occupied and unknown floor cells, if known.
    unit : str
        Of lengths.
    with_legend : bool
    sheet : Sheet, optional

    Returns
    -------
    matplotlib Figure
    """
    sheet = sheet or Sheet.of(SIZE, fits=True)
    named = sum(found.label != UNKNOWN for found in objects)
    axes = floor.floor_axes(
        sheet,
        f"Labelled occupancy: {_counted(named, len(objects))}" if with_legend else "Occupancy",
        unit,
    )
    outlines = [footprints.of_object(found, voxels) for found in objects]
    way = np.empty((0, 2)) if trajectory is None else trajectory[:, :3, 3][:, [0, 2]]
    handles = _draw_states(axes, states) if states is not None else _draw_occupied(axes, voxels)
    floor.show(axes, floor.extent_of(voxels), way, *outlines)
    handles += _draw_way(axes, way)
    handles += _draw_footprints(axes, objects, outlines, voxels)
    if trajectory is not None and len(trajectory):
        handles.append(floor.line("N: ahead of the\nfirst camera", marker="^", color=INK, lw=0))
    if with_legend:
        floor.add_legend(sheet, axes, handles)
    sheet.fit(axes)
    cover, reserved = _cover(axes, voxels), []
    if trajectory is not None and len(trajectory):
        reserved.append(floor.add_north(sheet, axes, trajectory[0, [0, 2], 2], cover))
    floor.add_scale_bar(sheet, axes, unit)
    _write_names(sheet, axes, zip(objects, outlines, strict=True), (cover, reserved))
    return sheet.figure


def _counted(named: int, found: int) -> str:
    if not found:
        return "no objects"
    return f"{named} named objects" + (f", {found - named} unknown" if found > named else "")


def _draw_occupied(axes: Any, voxels: Voxels) -> list[Any]:
    floor.draw_occupied(axes, voxels, OCCUPIED)
    return [floor.patch("occupied", color=OCCUPIED)]


def _draw_states(axes: Any, states: GroundGrid) -> list[Any]:
    from matplotlib.colors import to_rgb

    table = np.array([to_rgb(STATES[state]) for state in sorted(STATES)])
    floor.draw_grid(axes, states, table[states.cells.astype(int) - min(STATES)])
    axes.set_facecolor(STATES[ground.UNKNOWN])
    look = {"ec": FAINT, "lw": 0.6}
    called = {ground.OCCUPIED: "occupied", ground.FREE: "free", ground.UNKNOWN: "unknown"}
    return [floor.patch(name, fc=STATES[state], **look) for state, name in called.items()]


def _draw_way(axes: Any, way: Array) -> list[Any]:
    if not len(way):
        return []
    axes.plot(*way.T, color=WAY, lw=1.0, zorder=3, scalex=False, scaley=False)
    axes.plot(*way[0], "o", color=ACCENT, ms=5, zorder=6, scalex=False, scaley=False)
    start = floor.line("first camera", marker="o", color=ACCENT, ms=5, lw=0)
    return [start, floor.line("path of the camera", color=WAY)] if len(way) > 1 else [start]


def _draw_footprints(
    axes: Any, objects: Sequence[FoundObject], outlines: Sequence[Array], voxels: Voxels
) -> list[Any]:
    """Outline and cells of every object, in the colour of its kind."""
    from matplotlib.patches import Polygon

    kinds = sorted({found.label for found in objects} - {UNKNOWN})
    colours = {kind: SERIES[number % len(SERIES)] for number, kind in enumerate(kinds)}
    for found, outline in zip(objects, outlines, strict=True):
        colour = colours.get(found.label, INK)
        is_known = found.label in colours
        look: dict[str, Any] = {"ec": colour, "lw": 1.6 if is_known else 0.9}
        line = "-" if is_known else "--"
        axes.add_patch(Polygon(outline, fc="none", ls=line, zorder=5, **look))
        if is_known:
            axes.add_patch(Polygon(outline, fc=colour, ec="none", alpha=0.18, zorder=3.5))
            floor.draw_occupied(axes, cells_of(voxels, found), colour, zorder=4, alpha=0.75)
    handles = [floor.patch(kind, fc=(colour, 0.22), ec=colour) for kind, colour in colours.items()]
    if any(found.label == UNKNOWN for found in objects):
        handles.append(floor.patch("object without a name", fc="none", ec=INK, ls="--"))
    return handles


def _write_names(
    sheet: Sheet,
    axes: Any,
    objects: Iterable[tuple[FoundObject, Array]],
    taken: tuple[Cover, Sequence[Array]],
) -> None:
    """Write the name of every known object, off the cells and the reserved boxes."""
    texts = [
        names.Name(text=_name(found), box=_box(names.to_pixels(axes, outline)))
        for found, outline in objects
        if found.label != UNKNOWN
    ]
    names.write(sheet, axes, texts, *taken)


def _cover(axes: Any, voxels: Voxels) -> Cover:
    """The pixels of the axes that cells cover."""
    window = axes.get_window_extent()
    at = names.to_pixels(axes, voxels.centres[:, [0, 2]])
    across = np.ptp(names.to_pixels(axes, np.array([[0.0, 0.0], [voxels.cell_size, 0.0]]))[:, 0])
    return Cover(at, 0.5 * float(across), (int(window.width), int(window.height)))


def _box(at: Array) -> Array:
    """Left, top, right and bottom (4,) of points (N, 2)."""
    return np.concatenate([at.min(axis=0), at.max(axis=0)])


def _name(found: FoundObject) -> str:
    if found.probability is None:
        return found.label
    return f"{found.label} {found.probability:.0%}"
