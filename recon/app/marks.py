"""SVG overlays of an image: scales, names, the path, the clicked point."""

from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.app.drawing import Look, View
from recon.app.layers import COLOUR, Layer, with_unit
from recon.figures import scales
from recon.records import UNKNOWN, FoundObject, Trajectory
from recon.world.raster import Lens

Array = NDArray[np.float64]
Names = tuple[FoundObject, ...]

BAR = (1.1, 14.0)
"""Width and height of a scale, relative to its font size."""
SCENE_FONT, EYE_FONT = 13.0, 8.5
"""Font size of a scale in pixels, in a 3D view and in a camera's pane."""
STEPS = 32
ACCENT = "#e8650a"
FRUSTUM_SHARE = 0.04
"""Size of a camera's symbol, relative to its distance."""


def of_view(view: View, layer: Layer, look: Look, names: Names) -> str:
    """The colour scale, and the names of objects."""
    return _scale(layer, look) + "".join(_name(view.lens, found) for found in names)


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


def ring(u: float, v: float, radius: float, colour: str, more: str = "") -> str:
    """An unfilled circle."""
    return (
        f'<circle cx="{u:.1f}" cy="{v:.1f}" r="{radius:g}" fill="none" stroke="{colour}" '
        f'stroke-width="2" {more}/>'
    )


def polyline(at: Array, colour: str, width: float) -> str:
    """A line through points (N, 3) in pixels, interrupted behind the camera."""
    runs: list[list[str]] = [[]]
    for u, v, depth in at.tolist():
        if depth > 0 and abs(u) < 1e5 and abs(v) < 1e5:
            runs[-1].append(f"{u:.1f},{v:.1f}")
        elif runs[-1]:
            runs.append([])
    look = f'fill="none" stroke="{colour}" stroke-width="{width:g}"'
    return "".join(f'<polyline points="{" ".join(run)}" {look}/>' for run in runs if len(run) > 1)


def text(u: float, v: float, words: str, size: float = 13.0, anchor: str = "middle") -> str:
    """Text that is legible on any background."""
    return (
        f'<text class="recon-word" x="{u:.1f}" y="{v:.1f}" font-size="{size:g}" '
        f'text-anchor="{anchor}" stroke-width="{0.18 * size:.2g}">{escape(words)}</text>'
    )


def caption(words: str, size: tuple[int, int]) -> str:
    """The name of a pane, at the lower left of an image of `size` pixels."""
    font = 0.028 * size[0]
    return text(0.6 * font, size[1] - 0.6 * font, words, font, "start")


def length_bar(unit_px: float, size: tuple[int, int]) -> str:
    """A bar of 1, 2 or 5 times a power of ten units, at the lower right of an image."""
    width, height = size
    power = 10.0 ** np.floor(np.log10(0.25 * width / unit_px))
    length = power * max(digit for digit in (1, 2, 5) if digit * power * unit_px <= 0.25 * width)
    font = 0.028 * width
    right, low = width - 0.8 * font, height - 0.7 * font
    line = np.array([[right - length * unit_px, low, 1.0], [right, low, 1.0]])
    middle = right - 0.5 * length * unit_px
    words = text(middle, low - 0.5 * font, f"{length:g} units", font)
    return polyline(line, "#16191d", 4.0) + polyline(line, "#ffffff", 2.0) + words


def _name(lens: Lens, found: FoundObject) -> str:
    top = found.centre + np.array([0.0, 0.55 * found.size[1], 0.0])
    u, v, depth = lens.project(top[None])[0]
    # Many objects of a recording have no name: the table lists them by id.
    words = f"#{found.id}" if found.label == UNKNOWN else found.label
    return text(u, v, words) if depth > 0 else ""


def _scale(layer: Layer, look: Look) -> str:
    if look.colour_by == COLOUR or look.colour_by not in layer.columns:
        return ""
    label = with_unit(look.colour_by, look.unit)
    return scale(layer.columns[look.colour_by], label, scales.COUNT, SCENE_FONT)


def scale(values: Array, label: str, colours: Any, font: float = EYE_FONT) -> str:
    """The colour scale of values (N,), with its ends and its middle."""
    mapped = scales.coloured(values, colours)
    low, high = mapped.get_clim()
    width, tall = BAR[0] * font, BAR[1] * font
    height = tall / STEPS
    rows = scales.rgb(mapped, np.linspace(high, low, STEPS)).tolist()
    blocks = [
        f'<rect x="{font:.1f}" y="{2.4 * font + height * number:.1f}" width="{width:.1f}" '
        f'height="{height + 0.6:.1f}" fill="rgb({red},{green},{blue})"/>'
        for number, (red, green, blue) in enumerate(rows)
    ]
    words = [
        text(1.6 * font + width, 2.8 * font + share * tall, f"{value:.3g}", font, "start")
        for share, value in ((0.0, high), (0.5, (low + high) / 2.0), (1.0, low))
    ]
    return "".join([*blocks, *words, text(font, 1.4 * font, label, font, "start")])
