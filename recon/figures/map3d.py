"""The map in space (thesis figure 27): the exposed faces of its cells in their colours."""

import colorsys
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.figures.canvas import INK, PAPER, Image, Size
from recon.figures.solids import mesh as solid_mesh
from recon.geometry import look_at
from recon.libraries import load_pyvista
from recon.records import UNKNOWN, FoundObject, Voxels
from recon.voxelmap.faces import exposed_faces

SIZE: Size = (1200, 900)

VIEW_ANGLE_DEG = 28.0
FRAME = 1.1
"""Room round the map, for the names over it."""
STRAY = 0.02
"""Share of the cells, on each side, that may lie outside the image."""

# Directions from which the camera looks at the middle of the map.
VIEWS = {
    "default": (0.55, 0.75, 1.0),
    "top": (0.0, 1.0, 1e-3),
    "front": (0.0, 0.15, 1.0),
    "side": (1.0, 0.15, 0.0),
}


def map3d(
    voxels: Voxels,
    objects: Sequence[FoundObject] = (),
    view: str = "default",
    size: Size = SIZE,
    *,
    colours: NDArray[np.uint8] | None = None,
    with_solids: bool = False,
) -> Image:
    """Draw the occupied cells, with the names of the objects above them.

    Parameters
    ----------
    voxels : Voxels
    objects : sequence of FoundObject
    view : str
        A key of VIEWS.
    size : (width, height)
        Pixels.
    colours : (K, 3) uint8, optional
        Of the cells; their own where not given.
    with_solids : bool
        Draw the objects' fitted solids over pale cells.

    Raises
    ------
    InputError
        For a view that is none of VIEWS.
    """
    if view not in VIEWS:
        raise InputError(f"view is {view!r}, but one of {', '.join(VIEWS)} is needed")
    pyvista = load_pyvista()
    plotter = pyvista.Plotter(off_screen=True, window_size=list(size))
    try:
        plotter.set_background(PAPER)
        if len(voxels):
            painted = voxels if colours is None else replace(voxels, colours=colours)
            _add_cells(pyvista, plotter, painted, 0.25 if with_solids else 1.0)
            if with_solids:
                _add_solids(plotter, objects)
            _add_names(plotter, objects)
            _look(plotter, voxels, VIEWS[view])
        plotter.render()
        return np.asarray(plotter.screenshot(return_img=True), dtype=np.uint8)
    finally:
        plotter.close()


def by_value(values: NDArray[np.floating], cmap: str = "viridis") -> NDArray[np.uint8]:
    """Colours (K, 3) of numbers (K,), from the smallest to the largest."""
    from matplotlib import colormaps

    low, high = (values.min(), values.max()) if len(values) else (0.0, 0.0)
    share = (values - low) / (high - low if high > low else 1.0)
    colours: NDArray[np.uint8] = colormaps[cmap](share, bytes=True)[:, :3]
    return colours


def _add_cells(pyvista: Any, plotter: Any, voxels: Voxels, opacity: float) -> None:
    faces = exposed_faces(voxels)
    quads = np.arange(4 * len(faces.vertices)).reshape(-1, 4)
    cells = np.column_stack([np.full(len(quads), 4), quads]).ravel()
    mesh = pyvista.PolyData(faces.vertices.reshape(-1, 3), faces=cells)
    mesh.cell_data["colour"] = faces.colours
    plotter.add_mesh(
        mesh, scalars="colour", rgb=True, ambient=0.45, diffuse=0.6, specular=0.0,
        show_edges=False, opacity=opacity,
    )  # fmt: skip


def _add_solids(plotter: Any, objects: Sequence[FoundObject]) -> None:
    for part in [part for found in objects for part in found.parts]:
        hue = part.hue_deg
        colour = "#8a8a8a" if hue is None else colorsys.hsv_to_rgb(hue / 360.0, 0.7, 0.75)
        surface = solid_mesh(part.solid)
        plotter.add_mesh(surface, color=colour, opacity=0.75, ambient=0.35, smooth_shading=False)
        plotter.add_mesh(surface, color=INK, style="wireframe", opacity=0.15, line_width=1)


def _add_names(plotter: Any, objects: Sequence[FoundObject]) -> None:
    named = [found for found in objects if found.label != UNKNOWN]
    if not named:
        return
    tops = np.array([found.centre for found in named])
    tops[:, 1] += [found.size[1] * 0.6 for found in named]
    plotter.add_point_labels(
        tops, [found.label for found in named], font_size=18, text_color=INK,
        shape_color="white", shape_opacity=0.8, show_points=False, always_visible=True,
        font_family="arial", bold=False,
    )  # fmt: skip


def _look(plotter: Any, voxels: Voxels, direction: tuple[float, float, float]) -> None:
    """Stand as near as the whole box of the cells allows."""
    # Stray cells far out must not make the rest small.
    low, high = np.quantile(voxels.centres, (STRAY, 1.0 - STRAY), axis=0)
    low, high = low - voxels.cell_size, high + voxels.cell_size
    centre = (low + high) / 2.0
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    T_centre_camera = look_at(np.asarray(direction), np.zeros(3))
    seen = (corners - 0.5) * (high - low) @ T_centre_camera[:3, :3]
    width, height = plotter.window_size
    half = np.tan(np.radians(VIEW_ANGLE_DEG) / 2.0) * np.array([width / height, 1.0])
    distance = FRAME * float((np.abs(seen[:, :2]) / half - seen[:, 2:]).max())
    plotter.camera.focal_point = tuple(centre)
    plotter.camera.position = tuple(centre - distance * T_centre_camera[:3, 2])
    plotter.camera.up = (0.0, 1.0, 0.0)
    plotter.camera.view_angle = VIEW_ANGLE_DEG
    plotter.renderer.reset_camera_clipping_range()
