"""The scene of a 3D figure: cells, solids and the grid below them, in a PyVista Plotter."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import FAINT, Image, Size
from recon.figures.solids import drawn_solids
from recon.figures.solids import mesh as solid_mesh
from recon.figures.viewpoint import Box, Viewpoint
from recon.libraries import load_pyvista
from recon.records import FoundObject, Mesh, Voxels
from recon.voxelmap.faces import exposed_faces

BARE = "#cfcabd"
"""Colour of a surface without colours."""
FINER = 1.5
"""Rendered pixels per pixel of the image, along each side."""
MAX_SIDE_PX = 16384
"""Side of the largest image that is rendered."""
STRAY = 0.005
"""Share of the cells, on each side, that may lie outside the image."""
STRAY_REACH = 1.3
"""Outliers are shown if they extend the box by less than this factor."""


class Scene:
    """A PyVista Plotter filled step by step; notebooks show `plotter`."""

    def __init__(self, size: Size) -> None:
        self._size = size
        self._finer = max(1.0, min(FINER, MAX_SIDE_PX / max(size)))
        window = [round(self._finer * side) for side in size]
        self.plotter = load_pyvista().Plotter(off_screen=True, window_size=window)
        # Eight samples of every pixel, the default, take twice as long as finer pixels.
        self.plotter.render_window.SetMultiSamples(0)
        self.plotter.set_background("white")

    def add_cells(self, voxels: Voxels, opacity: float = 1.0) -> None:
        """The exposed faces of cells in their colours."""
        faces = exposed_faces(voxels)
        quads = np.arange(4 * len(faces.vertices)).reshape(-1, 4)
        cells = np.column_stack([np.full(len(quads), 4), quads]).ravel()
        mesh = load_pyvista().PolyData(faces.vertices.reshape(-1, 3), faces=cells)
        mesh.cell_data["colour"] = faces.colours
        # The back of an opaque cell is never seen, and takes as long as its front.
        hidden = "back" if opacity == 1.0 else None
        self.plotter.add_mesh(
            mesh, scalars="colour", rgb=True, ambient=0.45, diffuse=0.6, specular=0.0,
            show_edges=False, opacity=opacity, culling=hidden,
        )  # fmt: skip

    def add_solids(self, objects: Sequence[FoundObject], voxels: Voxels) -> None:
        """The closed solids of objects in the colours of their cells."""
        for found in objects:
            for one in drawn_solids(voxels, found):
                self.plotter.add_mesh(
                    solid_mesh(one.solid), color=one.colour,
                    ambient=0.4, diffuse=0.65, specular=0.0, smooth_shading=False,
                )  # fmt: skip

    def add_surface(self, surface: Mesh, *, is_bare: bool = False) -> None:
        """Triangles in their colours, or in one colour if bare or without colours."""
        faces = np.column_stack([np.full(len(surface), 3), surface.triangles]).ravel()
        shape = load_pyvista().PolyData(surface.vertices, faces=faces)
        look: dict[str, Any] = {"color": BARE, "ambient": 0.35}
        if surface.colours is not None and not is_bare:
            look = {"scalars": surface.colours, "rgb": True, "ambient": 0.7}
        self.plotter.add_mesh(shape, diffuse=0.6, specular=0.0, **look)

    def add_lines(self, lines: NDArray[np.float64], width: float = 1.0) -> None:
        """Straight lines (L, 2, 3) in a faint colour."""
        self.plotter.add_mesh(
            load_pyvista().line_segments_from_points(lines.reshape(-1, 3)), color=FAINT,
            line_width=width * self._finer, lighting=False,
        )  # fmt: skip

    def image(self, view: Viewpoint, *, is_clear: bool = False) -> Image:
        """The image (H, W, 3 or 4 if transparent) from a viewpoint; closes the plotter."""
        aim(self.plotter, view)
        try:
            self.plotter.render()
            shot: Any = self.plotter.screenshot(return_img=True, transparent_background=is_clear)
            return self._coarsened(np.asarray(shot, dtype=np.uint8))
        finally:
            self.plotter.close()

    def _coarsened(self, rendered: Image) -> Image:
        """The means of the rendered pixels, which smooth edges."""
        import PIL.Image

        fine = PIL.Image.fromarray(rendered)
        return np.asarray(fine.resize(self._size, PIL.Image.Resampling.BOX))


def aim(plotter: Any, view: Viewpoint) -> None:
    """Set a plotter's camera to a viewpoint."""
    T = view.T_world_cam
    camera = plotter.camera
    camera.position = tuple(T[:3, 3])
    camera.focal_point = tuple(T[:3, 3] + T[:3, 2])
    camera.up = tuple(-T[:3, 1])
    camera.view_angle = view.angle_deg
    if view.half_height is not None:
        camera.parallel_projection = True
        camera.parallel_scale = view.half_height
    plotter.renderer.reset_camera_clipping_range()


def box_of(voxels: Voxels) -> Box:
    """The box of the cells, without far outliers that would make the rest small."""
    low, high = np.quantile(voxels.centres, (STRAY, 1.0 - STRAY), axis=0)
    ends = voxels.centres.min(axis=0), voxels.centres.max(axis=0)
    is_near = ends[1] - ends[0] < STRAY_REACH * (high - low) + 2.0 * voxels.cell_size
    low, high = np.where(is_near, ends[0], low), np.where(is_near, ends[1], high)
    return low - voxels.cell_size, high + voxels.cell_size
