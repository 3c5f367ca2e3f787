"""A mesh seen from where its cameras stood, in its own colours and as bare shape."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import Sheet, Size
from recon.figures.frame import axes_size
from recon.figures.map3d import space_axes
from recon.figures.scene import Scene
from recon.figures.viewpoint import Viewpoint
from recon.geometry import look_at
from recon.records import Mesh

Array = NDArray[np.float64]
SIZE: Size = (1600, 800)

_VIEW_ANGLE_DEG = 30.0
_STRAY = 0.02
"""Share of the vertices, on each side, that may lie outside the image."""


def mesh(surface: Mesh, cameras: Array, *, sheet: Sheet | None = None) -> Any:
    """A mesh twice, side by side: with its colours, and without.

    Parameters
    ----------
    surface : Mesh
        World, y up.
    cameras : (N, 3)
        Where the cameras stood; it is seen from their side.
    sheet : Sheet, optional

    Returns
    -------
    matplotlib Figure
    """
    sheet = sheet or Sheet.of(SIZE)
    titles = f"Mesh: {len(surface):,} triangles", "Its shape"
    for panel, title, is_bare in zip(sheet.panels(1, 2)[0], titles, (False, True), strict=True):
        axes = space_axes(panel, title, with_bar=False)
        if not len(surface):
            continue
        scene = Scene(axes_size(axes))
        scene.add_surface(surface, is_bare=is_bare)
        shot = scene.image(
            _viewpoint(surface, cameras), is_clear=sheet.style.background == "transparent"
        )
        axes.imshow(shot, aspect="auto", interpolation="none")
    return sheet.figure


def _viewpoint(surface: Mesh, cameras: Array) -> Viewpoint:
    """From the side on which most of the cameras stood, to the middle of the mesh."""
    low, high = np.quantile(surface.vertices, (_STRAY, 1 - _STRAY), axis=0)
    middle = (low + high) / 2
    reach = float(np.linalg.norm(high - low)) or 1.0
    side = np.mean(cameras, axis=0) - middle if len(cameras) else np.zeros(3)
    if len(cameras) and np.linalg.norm(side) < 0.1 * reach:
        # Cameras all round: from the first one's side.
        side = cameras[0] - middle
    if np.hypot(side[0], side[2]) < 1e-9 * reach:
        side = np.array([0.0, 0.3, 1.0])
    distance = 0.75 * reach / 2 / np.tan(np.radians(_VIEW_ANGLE_DEG) / 2)
    place = middle + distance * side / np.linalg.norm(side)
    return Viewpoint(T_world_cam=look_at(place, middle), angle_deg=_VIEW_ANGLE_DEG)
