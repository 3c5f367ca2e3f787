"""A mesh seen from where its cameras stood, in its own colours and as bare shape."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import PAPER, Image, Size
from recon.libraries import load_pyvista
from recon.records import Mesh

SIZE: Size = (1600, 800)
_VIEW_ANGLE_DEG = 30.0
_STRAY = 0.02
"""Share of the vertices, on each side, that may lie outside the image."""


def mesh(surface: Mesh, cameras: NDArray[np.float64], size: Size = SIZE) -> Image:
    """Draw a mesh twice, side by side: with its colours, and without.

    Parameters
    ----------
    surface : Mesh
        World, y up.
    cameras : (N, 3)
        Where the cameras stood; it is seen from their side.
    size : (width, height)
        Pixels.
    """
    pyvista = load_pyvista()
    plotter = pyvista.Plotter(off_screen=True, window_size=list(size), shape=(1, 2), border=False)
    try:
        plotter.set_background(PAPER)
        if len(surface):
            _add(pyvista, plotter, surface, cameras)
        plotter.render()
        return np.asarray(plotter.screenshot(return_img=True), dtype=np.uint8)
    finally:
        plotter.close()


def _add(pyvista: Any, plotter: Any, surface: Mesh, cameras: NDArray[np.float64]) -> None:
    faces = np.column_stack([np.full(len(surface), 3), surface.triangles]).ravel()
    shape = pyvista.PolyData(surface.vertices, faces=faces)
    for column, colours in enumerate((surface.colours, None)):
        plotter.subplot(0, column)
        look = {"color": "#cfcabd"} if colours is None else {"scalars": colours, "rgb": True}
        plotter.add_mesh(
            shape.copy(),
            ambient=0.35 if colours is None else 0.7,
            diffuse=0.6,
            specular=0.0,
            **look,
        )
        _look(plotter, surface, cameras)


def _look(plotter: Any, surface: Mesh, cameras: NDArray[np.float64]) -> None:
    """Look at the middle of the mesh from the side on which most of the cameras stood."""
    low, high = np.quantile(surface.vertices, (_STRAY, 1 - _STRAY), axis=0)
    middle = (low + high) / 2
    side = np.mean(cameras, axis=0) - middle
    reach = float(np.linalg.norm(high - low))
    if np.linalg.norm(side) < 0.1 * reach:
        # Cameras all round: from the first one's side.
        side = cameras[0] - middle
    if np.linalg.norm(side) < 1e-9:
        side = np.array([0.0, 0.0, 1.0])
    distance = 0.75 * reach / 2 / np.tan(np.radians(_VIEW_ANGLE_DEG) / 2)
    plotter.camera.focal_point = tuple(middle)
    plotter.camera.position = tuple(middle + distance * side / np.linalg.norm(side))
    plotter.camera.up = (0.0, 1.0, 0.0)
    plotter.camera.view_angle = _VIEW_ANGLE_DEG
    plotter.renderer.reset_camera_clipping_range()
