"""A mesh seen from the side of its cameras, in its own colours and as plain shape."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import Sheet, Size
from recon.figures.cover import Cover
from recon.figures.frame import axes_size
from recon.figures.map3d import Stage, Standpoint, show_scene, space_axes
from recon.figures.scene import Scene
from recon.figures.viewpoint import Box, Viewpoint, framed
from recon.records import Mesh

Array = NDArray[np.float64]
SIZE: Size = (1600, 800)

_STRAY = 0.002
"""Share of the vertices, on each side, that may lie outside the image."""
_MARGIN = 0.02
_DOT_PX = 4.0
_RISE = 0.25
"""Minimum height of the viewpoint, relative to its horizontal distance."""


def mesh(
    surface: Mesh,
    cameras: Array,
    *,
    standpoint: Standpoint | None = None,
    sheet: Sheet | None = None,
) -> Any:
    """A mesh twice, side by side: with its colours, and without.

    Parameters
    ----------
    surface : Mesh
        World, y up.
    cameras : (N, 3)
        Camera positions; by default it is seen from their side.
    standpoint : Standpoint, optional
    sheet : Sheet, optional

    Returns
    -------
    matplotlib Figure
    """
    sheet = sheet or Sheet.of(SIZE)
    standpoint = standpoint or Standpoint()
    titles = f"Mesh: {len(surface):,} triangles", "Its shape"
    for panel, title, is_bare in zip(sheet.panels(1, 2)[0], titles, (False, True), strict=True):
        axes = space_axes(panel, title, with_bar=False)
        if not len(surface):
            continue
        size = axes_size(axes)
        scene = Scene(size)
        scene.add_surface(surface, is_bare=is_bare)
        box = _box(surface)
        view = _viewpoint(box, cameras, standpoint, size)
        at = view.project(surface.vertices, size)
        cover = Cover(at[at[:, 2] > 0, :2], _DOT_PX, size)
        show_scene(panel, axes, (scene, view), Stage(box=box, unit=standpoint.unit), cover)
    return sheet.figure


def _box(surface: Mesh) -> Box:
    low, high = np.quantile(surface.vertices, (_STRAY, 1.0 - _STRAY), axis=0)
    margin = _MARGIN * (float((high - low).max()) or 1.0)
    return low - margin, high + margin


def _viewpoint(box: Box, cameras: Array, standpoint: Standpoint, size: Size) -> Viewpoint:
    """The requested view, by default from the side of most of the cameras."""
    if standpoint.view != "default":
        return standpoint.viewpoint(box, size)
    middle, reach = (box[0] + box[1]) / 2.0, float(np.linalg.norm(box[1] - box[0]))
    side = np.mean(cameras, axis=0) - middle if len(cameras) else np.zeros(3)
    if len(cameras) and np.hypot(side[0], side[2]) < 0.1 * reach:
        # Cameras on all sides: from the first one's side.
        side = cameras[0] - middle
    if np.hypot(side[0], side[2]) < 1e-9 * reach:
        side = np.array([0.0, 0.3, 1.0])
    level = float(np.hypot(side[0], side[2]))
    # Slightly from above, so that the floor is visible.
    side[1] = max(side[1], _RISE * level)
    return framed(side, box, size)
