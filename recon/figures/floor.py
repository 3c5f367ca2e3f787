"""Floor plans: x to the right, z down the page, so that -z, which is ahead, is up."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import INK, QUIET, Sheet
from recon.figures.cover import Cover
from recon.figures.scales import round_length
from recon.figures.scene import box_of
from recon.records import GroundGrid, Voxels
from recon.voxelmap.ground import height_sum

Array = NDArray[np.float64]

MARGIN = 0.06
"""Margin around the content, as a share of its longer side."""
NORTH_LINES = 5.4
"""Size of the north arrow, in lines of text."""
SCALE_SHARE = 0.22
"""Approximate length of the scale bar, as a share of the sheet's width."""


def floor_axes(sheet: Sheet, title: str, unit: str) -> Any:
    """Axes of equal scale."""
    axes = sheet.axes(title, f"x [{unit}]", f"z [{unit}]")
    axes.set_aspect("equal")
    return axes


def show(axes: Any, *shown: Array) -> None:
    """Set the limits so that points (N, 2) in x, z are visible."""
    points = np.vstack([part.reshape(-1, 2) for part in shown])
    if not len(points):
        return
    low, high = points.min(axis=0), points.max(axis=0)
    margin = MARGIN * float((high - low).max()) or 1.0
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(high[1] + margin, low[1] - margin))


def extent_of(voxels: Voxels) -> Array:
    """Two corners (2, 2) in x, z of the cells, without far outliers; (0, 2) without cells."""
    return np.array(box_of(voxels))[:, [0, 2]] if len(voxels) else np.empty((0, 2))


def draw_grid(axes: Any, grid: GroundGrid, values: NDArray[Any], **look: Any) -> Any:
    """Draw values (NX, NZ) of floor cells, or their colours (NX, NZ, 3 or 4)."""
    x, z = grid.origin_xz
    far_x, far_z = grid.origin_xz + np.array(grid.cells.shape[:2]) * grid.cell_size
    return axes.imshow(
        np.moveaxis(values, 0, 1), extent=(x, far_x, far_z, z), interpolation="none",
        **{"zorder": 2, **look},
    )  # fmt: skip


def draw_occupied(axes: Any, voxels: Voxels, colour: str, **look: Any) -> None:
    """Draw the floor cells below occupied cells in one colour."""
    from matplotlib.colors import ListedColormap

    if not len(voxels):
        return
    grid = height_sum(voxels)
    is_empty = np.asarray(grid.cells, np.float64) <= 0
    shown = np.ma.masked_where(is_empty, np.ones(is_empty.shape))
    draw_grid(axes, grid, shown, cmap=ListedColormap([colour]), **look)


def add_scale_bar(sheet: Sheet, axes: Any, unit: str) -> None:
    """Add a bar of 1, 2 or 5 times a power of ten world units at the lower left."""
    left, right = axes.get_xlim()
    length = round_length(SCALE_SHARE * (right - left))
    share = length / (right - left)
    place = {"transform": axes.transAxes, "zorder": 10, "clip_on": False}
    axes.plot([0.03, 0.03 + share], [0.025, 0.025], color=INK, lw=2.2, solid_capstyle="butt",
              scalex=False, scaley=False, **place)  # fmt: skip
    axes.text(0.03, 0.035, f"{length:g} {unit}", ha="left", va="bottom", color=INK,
              fontsize=0.9 * sheet.font_size, bbox=_halo(), **place)  # fmt: skip


def add_north(sheet: Sheet, axes: Any, ahead: Array, cover: Cover) -> Array:
    """Add an arrow along the first camera's direction (2,) in x, z, in the emptiest corner.

    Returns
    -------
    (4,) ndarray
        Left, top, right and bottom of the arrow, pixels of the axes, y down.
    """
    window = axes.get_window_extent()
    reach = 1.4 * sheet.line_px
    towards = ahead / max(float(np.linalg.norm(ahead)), 1e-12) * (1.0, -1.0)
    box = _emptiest_corner(sheet, (window.width, window.height), cover)
    middle = (box[:2] + box[2:]) / 2.0 * (1.0, -1.0) + (0.0, window.height)
    tail, head = ((middle + sign * reach * towards) / (window.width, window.height)
                  for sign in (-1.0, 1.0))  # fmt: skip
    axes.annotate(
        "", head, tail, xycoords="axes fraction", textcoords="axes fraction", zorder=10,
        arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.4, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    beyond = (middle + (reach + 0.6 * sheet.line_px) * towards) / (window.width, window.height)
    axes.text(*beyond, "N", transform=axes.transAxes, ha="center", va="center", color=INK,
              fontsize=sheet.font_size, weight="bold", zorder=10, bbox=_halo())  # fmt: skip
    return box


def _emptiest_corner(sheet: Sheet, size: tuple[float, float], cover: Cover) -> Array:
    """Left, top, right and bottom of room for an arrow; the scale bar is at the lower left."""
    room = NORTH_LINES * sheet.line_px
    right, bottom = size[0] - room, size[1] - room
    corners = np.array([[0.0, 0.0], [right, 0.0], [right, bottom]])
    boxes = np.hstack([corners, corners + room])
    box: Array = boxes[np.argmin(cover.area(boxes))]
    return box


def _halo() -> dict[str, Any]:
    return {"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.75}


def add_legend(sheet: Sheet, axes: Any, handles: list[Any]) -> None:
    """Add the legend to the right of the axes, however narrow they are."""
    axes.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False,
        fontsize=0.9 * sheet.font_size, labelcolor=INK, borderaxespad=0.6, handlelength=1.6,
    )  # fmt: skip


def line(label: str, **look: Any) -> Any:
    """A line entry of a legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=label, **{"color": QUIET, "lw": 1.0, **look})


def patch(label: str, **look: Any) -> Any:
    """An area entry of a legend."""
    from matplotlib.patches import Patch

    return Patch(label=label, **look)
