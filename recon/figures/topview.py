"""The world from above: occupancy (thesis figures 30 to 32), its labels, and the agent's path.

x runs to the right and z down the page, so that an agent that looks along -z looks up it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import ACCENT, FAINT, INK, Image, Size, new_axes, new_figure, to_image
from recon.records import UNKNOWN, FoundObject, Voxels

Array = NDArray[np.float64]
SIZE: Size = (900, 860)
STRAY = 0.01
"""Share of the cells, on each side, that may lie outside the sheet."""


def occupancy(voxels: Voxels, size: Size = SIZE) -> Image:
    """Points over every floor cell, summed over height."""
    figure = new_figure(size)
    axes = _axes(figure, "Occupancy: points summed over height")
    _draw_counts(figure, axes, voxels)
    _frame(axes)
    return to_image(figure)


def labels(
    voxels: Voxels,
    objects: Sequence[FoundObject],
    trajectory: Array | None = None,
    size: Size = SIZE,
) -> Image:
    """Occupancy in the map's own colours, with every object's outline, name and probability.

    What has no name has an outline only.

    The sheet holds the map and its objects; the trajectory may leave it.

    Parameters
    ----------
    voxels : Voxels
    objects : sequence of FoundObject
    trajectory : (N, 3), optional
        Positions of the eyes in the world.
    """
    figure = new_figure(size)
    axes = _axes(
        figure, f"Occupancy with labels: {sum(o.label != UNKNOWN for o in objects)} objects"
    )
    _draw_colours(axes, voxels)
    for found in objects:
        _draw_label(axes, found)
    _frame(axes)
    if trajectory is not None:
        axes.plot(trajectory[:, 0], trajectory[:, 2], color=FAINT, lw=0.8, zorder=1)
    return to_image(figure)


def path(trajectory: Array, voxels: Voxels, size: Size = SIZE) -> Image:
    """The way the eyes took, over what they mapped.

    Parameters
    ----------
    trajectory : (N, 4, 4)
        `T_world_left` of every pair.
    voxels : Voxels
    """
    figure = new_figure(size)
    axes = _axes(figure, f"Trajectory: {len(trajectory)} pairs")
    _draw_colours(axes, voxels)
    at, gaze = trajectory[:, :3, 3], trajectory[:, :3, 2]
    axes.plot(at[:, 0], at[:, 2], color=INK, lw=0.8, alpha=0.6, zorder=2)
    order = np.arange(len(at))
    axes.update_datalim((at + gaze)[:, [0, 2]])
    axes.quiver(
        at[:, 0], at[:, 2], gaze[:, 0], gaze[:, 2], order, cmap="plasma", zorder=3,
        angles="xy", scale=40, width=0.0025,
    )  # fmt: skip
    if len(at):
        axes.plot(at[0, 0], at[0, 2], "o", color=ACCENT, ms=6, zorder=4)
    _frame(axes)
    return to_image(figure)


def _axes(figure: Any, title: str) -> Any:
    axes = new_axes(figure, title, "x [world units]", "z [world units]")
    axes.set_aspect("equal")
    return axes


def _frame(axes: Any) -> None:
    """A square round all that was drawn so far, if anything was, with z down the page."""
    box = axes.dataLim
    if not np.isfinite(box.bounds).all():
        return
    half = 0.6 * max(box.width, box.height) or 1.0
    middle_x, middle_z = (box.x0 + box.x1) / 2.0, (box.y0 + box.y1) / 2.0
    axes.set(xlim=(middle_x - half, middle_x + half), ylim=(middle_z + half, middle_z - half))


def _draw_counts(figure: Any, axes: Any, voxels: Voxels) -> None:
    columns, inverse = np.unique(voxels.index[:, [0, 2]], axis=0, return_inverse=True)
    counts = np.bincount(inverse.ravel(), weights=voxels.counts, minlength=len(columns))
    _draw_cells(axes, columns, voxels.cell_size, np.log10(np.maximum(counts, 1)), "magma_r")
    if len(columns):
        bar = figure.colorbar(axes.collections[0], ax=axes, shrink=0.6, pad=0.01)
        bar.set_label("points, log10", color=INK, fontsize=9)


def _draw_colours(axes: Any, voxels: Voxels) -> None:
    order = np.argsort(voxels.index[:, 1], kind="stable")
    columns, last = np.unique(voxels.index[order][::-1][:, [0, 2]], axis=0, return_index=True)
    colours = voxels.colours[order][::-1][last] / 255.0
    _draw_cells(axes, columns, voxels.cell_size, colours, None)


def _draw_cells(
    axes: Any, columns: NDArray[np.int64], cell: float, values: Array, cmap: str | None
) -> None:
    from matplotlib.collections import PolyCollection

    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    squares = PolyCollection((columns[:, None] + corners) * cell, linewidths=0, zorder=2)
    if cmap is None:
        squares.set_facecolor([(r, g, b) for r, g, b in values.tolist()])
    else:
        squares.set(array=values, cmap=cmap)
    axes.add_collection(squares, autolim=False)
    if len(columns):
        # Stray cells far out must not make the rest small.
        axes.update_datalim(np.quantile(columns + 0.5, (STRAY, 1.0 - STRAY), axis=0) * cell)


def _draw_label(axes: Any, found: FoundObject) -> None:
    from matplotlib.patches import Ellipse

    x, _, z = found.centre
    width, _, depth = found.size * 1.15
    if found.label == UNKNOWN:
        axes.add_patch(Ellipse((x, z), width, depth, fill=False, ec=FAINT, lw=1.0, zorder=4))
        return
    axes.add_patch(Ellipse((x, z), width, depth, fill=False, ec=ACCENT, lw=1.2, zorder=4))
    axes.annotate(
        f"{found.label}\n{found.probability:.0%}", (x, z - depth / 2.0), zorder=5, color=INK,
        ha="center", va="bottom", fontsize=8.5, xytext=(0, 3), textcoords="offset points",
        bbox={"boxstyle": "round,pad=0.25", "fc": "white", "ec": FAINT, "alpha": 0.85},
    )  # fmt: skip
