"""The path of the cameras, over their map."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import floor, scales
from recon.figures.canvas import ACCENT, QUIET, Sheet, Size
from recon.figures.map3d import UNITS
from recon.records import Voxels

Array = NDArray[np.float64]
SIZE: Size = (1000, 860)

MAPPED = "#d3d8dc"
MAX_ARROWS = 120
"""More would hide each other; the path is drawn completely."""


def trajectory(
    T_world_left: Array, voxels: Voxels, *, unit: str = UNITS, sheet: Sheet | None = None
) -> Any:
    """The path of the left camera with its direction at every pair, in the order of the pairs.

    Parameters
    ----------
    T_world_left : (N, 4, 4)
        Pose of every pair.
    voxels : Voxels
        Occupied cells, drawn pale in the background.
    unit : str
        Of lengths.
    sheet : Sheet, optional

    Returns
    -------
    matplotlib Figure
    """
    sheet = sheet or Sheet.of(SIZE, fits=True)
    axes = floor.floor_axes(
        sheet,
        f"Trajectory: {len(T_world_left)} {'pair' if len(T_world_left) == 1 else 'pairs'}",
        unit,
    )
    if len(voxels):
        floor.draw_occupied(axes, voxels, MAPPED)
    at, gaze = T_world_left[:, :3, 3][:, [0, 2]], T_world_left[:, :3, 2][:, [0, 2]]
    floor.show(axes, floor.extent_of(voxels), at)
    axes.plot(*at.T, color=QUIET, lw=0.8, zorder=3)
    handles = [floor.line("path of the left camera")]
    if len(at):
        axes.plot(*at[0], "o", color=ACCENT, ms=6, zorder=5)
        handles.append(floor.line("first camera", marker="o", color=ACCENT, ms=6, lw=0))
    if len(at) > 1:
        _draw_directions(sheet, axes, at, gaze)
    if len(voxels):
        handles.append(floor.patch("occupied", color=MAPPED))
    axes.legend(handles=handles, loc="best", framealpha=0.85, edgecolor="none",
                fontsize=0.9 * sheet.font_size)  # fmt: skip
    sheet.fit(axes)
    floor.add_scale_bar(sheet, axes, unit)
    return sheet.figure


def _draw_directions(sheet: Sheet, axes: Any, at: Array, gaze: Array) -> None:
    shown = np.unique(np.linspace(0, len(at) - 1, min(MAX_ARROWS, len(at))).astype(int))
    # z points down the page. matplotlib's own angles="xy" fails if all cameras are at the origin.
    angles = np.degrees(np.arctan2(-gaze[shown, 1], gaze[shown, 0]))
    arrows = axes.quiver(
        *at[shown].T, *gaze[shown].T, shown, cmap=scales.ORDER, zorder=4, angles=angles, scale=28,
        width=0.003,
    )  # fmt: skip
    arrows.set_clim(0, len(at) - 1)
    sheet.colour_bar(arrows, axes, "number of the pair")
