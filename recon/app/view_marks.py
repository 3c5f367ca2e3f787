"""SVG overlays of a 3D view: the scale, names, the path of the cameras, the clicked point."""

import numpy as np

from recon.app.drawing import View
from recon.app.layers import Layer
from recon.app.looks import COLOUR, Look, name_of, top_of, with_unit
from recon.app.marks import polyline, ring, scale, text
from recon.figures import scales
from recon.records import FoundObject, Trajectory
from recon.world.raster import Lens

Names = tuple[FoundObject, ...]

FONT = 13.0
"""Pixels of a scale's letters."""
ACCENT = "#e8650a"
FRUSTUM_SHARE = 0.04
"""Size of a camera's symbol, of the distance at which it is seen."""


def of_view(view: View, look: Look, names: Names) -> str:
    """The scale of the colours, and the names of objects."""
    return _scale(view.layer, look) + "".join(_name(view.lens, found) for found in names)


def of_trajectory(lens: Lens, trajectory: Trajectory | None, pair: int) -> str:
    """The path of the cameras, and the camera of one pair."""
    if trajectory is None or not len(trajectory):
        return ""
    way = polyline(lens.project(trajectory.positions), "#56b4e9", 1.5)
    T = trajectory.T_world_left[min(pair, len(trajectory) - 1)]
    (depth,) = lens.project(T[None, :3, 3])[:, 2]
    size = FRUSTUM_SHARE * max(float(depth), 1e-9)
    corners = np.array([[-1, -0.75, 1.4], [1, -0.75, 1.4], [1, 0.75, 1.4], [-1, 0.75, 1.4]]) * size
    world = corners @ T[:3, :3].T + T[:3, 3]
    eye = T[:3, 3]
    rays = "".join(polyline(lens.project(np.array([eye, one])), ACCENT, 1.5) for one in world)
    return way + rays + polyline(lens.project(np.vstack([world, world[:1]])), ACCENT, 1.5)


def of_row(lens: Lens, layer: Layer, row: int | None) -> str:
    """A ring around the clicked point."""
    if row is None or row >= len(layer):
        return ""
    u, v, depth = lens.project(layer.places[row : row + 1])[0]
    return ring(u, v, 8.0, ACCENT) if depth > 0 else ""


def _name(lens: Lens, found: FoundObject) -> str:
    u, v, depth = lens.project(top_of(found)[None])[0]
    return text(u, v - 4.0, name_of(found)) if depth > 0 else ""


def _scale(layer: Layer, look: Look) -> str:
    if look.colour_by == COLOUR or look.colour_by not in layer.columns:
        return ""
    label = with_unit(look.colour_by, look.unit)
    return scale(layer.columns[look.colour_by], label, scales.COUNT, FONT)
