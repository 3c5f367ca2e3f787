"""Lines and words over an image, as SVG: scales, names, the way, what was clicked."""

from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from recon.app.drawing import Look, View
from recon.app.layers import COLOUR, Layer
from recon.figures import scales
from recon.records import FoundObject, Trajectory
from recon.world.raster import Lens

Array = NDArray[np.float64]
Names = tuple[FoundObject, ...]

BAR = (14.0, 200.0)
"""Width and height of a scale in pixels."""
STEPS = 32
ACCENT = "#e8650a"
FRUSTUM_SHARE = 0.04
"""Size of a camera's symbol, of the distance at which it is seen."""


def of_view(view: View, layer: Layer, look: Look, names: Names) -> str:
    """The scale of the colours, and the names of objects."""
    return _scale(layer, look) + "".join(_name(view.lens, found) for found in names)


def of_trajectory(lens: Lens, trajectory: Trajectory | None, pair: int) -> str:
    """The way of the cameras, and the camera of one pair."""
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
    """A ring round what was clicked."""
    if row is None or row >= len(layer):
        return ""
    u, v, depth = lens.project(layer.places[row : row + 1])[0]
    return ring(u, v, 8.0, ACCENT) if depth > 0 else ""


def ring(u: float, v: float, radius: float, colour: str, more: str = "") -> str:
    """A circle without a filling."""
    return (
        f'<circle cx="{u:.1f}" cy="{v:.1f}" r="{radius:g}" fill="none" stroke="{colour}" '
        f'stroke-width="2" {more}/>'
    )


def polyline(at: Array, colour: str, width: float) -> str:
    """A line through points (N, 3) in pixels; broken where it goes behind the camera."""
    runs: list[list[str]] = [[]]
    for u, v, depth in at.tolist():
        if depth > 0 and abs(u) < 1e5 and abs(v) < 1e5:
            runs[-1].append(f"{u:.1f},{v:.1f}")
        elif runs[-1]:
            runs.append([])
    look = f'fill="none" stroke="{colour}" stroke-width="{width:g}"'
    return "".join(f'<polyline points="{" ".join(run)}" {look}/>' for run in runs if len(run) > 1)


def text(u: float, v: float, words: str, size: float = 13.0, anchor: str = "middle") -> str:
    """Words that can be read over anything."""
    return (
        f'<text x="{u:.1f}" y="{v:.1f}" font-size="{size:g}" text-anchor="{anchor}" '
        'font-family="sans-serif" fill="#fff" stroke="#111" stroke-width="3" '
        f'paint-order="stroke">{escape(words)}</text>'
    )


def _name(lens: Lens, found: FoundObject) -> str:
    top = found.centre + np.array([0.0, 0.55 * found.size[1], 0.0])
    u, v, depth = lens.project(top[None])[0]
    return text(u, v, found.label) if depth > 0 else ""


def _scale(layer: Layer, look: Look) -> str:
    """The colours of a column, with its ends and its middle."""
    if look.colour_by == COLOUR or look.colour_by not in layer.columns:
        return ""
    scale = scales.coloured(layer.columns[look.colour_by], scales.COUNT)
    low, high = scale.get_clim()
    colours = scales.rgb(scale, np.linspace(high, low, STEPS))
    height = BAR[1] / STEPS
    blocks = [
        f'<rect x="16" y="{30 + height * number:.1f}" width="{BAR[0]}" height="{height + 0.6:.1f}" '
        f'fill="rgb({red},{green},{blue})"/>'
        for number, (red, green, blue) in enumerate(colours.tolist())
    ]
    ends = [(high, 36.0), ((low + high) / 2.0, 34.0 + BAR[1] / 2.0), (low, 30.0 + BAR[1])]
    words = [text(36.0, v, f"{value:.4g}", 12.0, "start") for value, v in ends]
    return "".join([*blocks, *words, text(16.0, 20.0, look.colour_by, 13.0, "start")])


def frame_marks(at: Sequence[tuple[float, float]], colours: Sequence[str], radius: float) -> str:
    """Dots at pixels, each in its colour."""
    return "".join(
        f'<circle cx="{u:.1f}" cy="{v:.1f}" r="{radius:g}" fill="{colour}"/>'
        for (u, v), colour in zip(at, colours, strict=True)
    )
