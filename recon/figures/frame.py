"""The frame of a 3D figure: a grid on the floor, and numbers along its edges."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import FAINT, INK, POINTS_PER_INCH, QUIET, Sheet
from recon.figures.cover import Cover
from recon.figures.names import LETTER_WIDTH
from recon.figures.viewpoint import Box, Viewpoint

Array = NDArray[np.float64]

NUM_STEPS = 5
"""Approximate number of grid steps along a side of the floor."""
NUM_UPWARDS = 2.5
NAMES = "xyz"
# Possible edges along x, y or z, as ends of the other two axes; x and z stay on the floor.
_CORNERS = {
    0: ((0, 0), (0, 1)),
    1: ((0, 0), (0, 1), (1, 0), (1, 1)),
    2: ((0, 0), (1, 0)),
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Edge:
    """One edge of the box with its numbers, in the image."""

    axis: int
    places: Array
    """(N,) numbers."""
    at: Array
    """(N, 2) pixels."""
    out: Array
    """(2,) unit, away from the centre of the box."""


def step_of(box: Box) -> float:
    """Spacing of the grid lines: 1, 2 or 5 times a power of ten."""
    return _rounded(float(np.sqrt(np.prod((box[1] - box[0])[[0, 2]]))) / NUM_STEPS)


def _rounded(length: float) -> float:
    power = 10.0 ** np.floor(np.log10(length))
    return float(power * min((1.0, 2.0, 5.0, 10.0), key=lambda digit: abs(digit * power - length)))


def floor_lines(box: Box) -> Array:
    """The lines (L, 2, 3) of the grid on the floor of a box, including its border."""
    low, high = box
    lines = []
    for along, across in ((0, 2), (2, 0)):
        inner = ticks(low[along], high[along], step_of(box))
        for place in (low[along], *inner, high[along]):
            line = np.array([low, low])
            line[:, along] = place
            line[:, across] = low[across], high[across]
            lines.append(line)
    return np.array(lines)


def ticks(low: float, high: float, step: float) -> Array:
    """Multiples of `step` from `low` to `high`."""
    first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
    return np.arange(first, last + 1) * step + 0.0


def add_numbers(sheet: Sheet, axes: Any, box: Box, view: Viewpoint, cover: Cover) -> list[str]:
    """Number the clearest edge of the box for each axis; return the numbered axes."""
    numbered = []
    for axis in range(3):
        edge = _best_edge(sheet, axes_size(axes), box, view, (axis, cover))
        if edge is not None:
            numbered.append(NAMES[axis])
            _number(sheet, axes, edge)
    return numbered


def axes_size(axes: Any) -> tuple[int, int]:
    """Width and height of axes in pixels."""
    box = axes.get_window_extent()
    return max(round(box.width), 1), max(round(box.height), 1)


def _best_edge(
    sheet: Sheet, size: tuple[int, int], box: Box, view: Viewpoint, wanted: tuple[int, Cover]
) -> Edge | None:
    axis, cover = wanted
    step = step_of(box)
    if axis == 1:
        step = min(step, _rounded((box[1][1] - box[0][1]) / NUM_UPWARDS))
    places = ticks(box[0][axis], box[1][axis], step)
    middle = view.project([(box[0] + box[1]) / 2.0], size)[0, :2]
    edges = []
    for corner in _CORNERS[axis]:
        at = view.project(_edge_points(box, axis, places, corner), size)
        edge = _edge(sheet, axis, places, at, (middle, size))
        if edge is None:
            continue
        covered = _covered(sheet, edge, cover)
        if covered <= len(edge.places) / 2:
            edges.append(((-covered, len(edge.places) > 2, _outside(edge, middle)), edge))
    return max(edges, key=lambda pair: pair[0])[1] if edges else None


def _edge(
    sheet: Sheet, axis: int, places: Array, at: Array, image: tuple[Array, tuple[int, int]]
) -> Edge | None:
    """The part of an edge with room for its numbers; None if there are fewer than two."""
    middle, size = image
    margin = 1.2 * sheet.line_px
    inside = (at[:, 2] > 0) & (at[:, :2] > margin).all(axis=1)
    inside &= (at[:, :2] < np.array(size) - margin).all(axis=1)
    seen = at[inside, :2]
    if len(seen) < 2:
        return None
    along = seen[-1] - seen[0]
    length = float(np.linalg.norm(along))
    if length < 2.2 * sheet.line_px * (len(seen) - 1):
        return None
    out = np.array([-along[1], along[0]]) / length
    out = out if (seen.mean(axis=0) - middle) @ out >= 0 else -out
    return Edge(axis=axis, places=places[inside], at=seen, out=out)


def _covered(sheet: Sheet, edge: Edge, cover: Cover) -> int:
    """Count of an edge's numbers that would overlap the drawing."""
    at = edge.at + edge.out * 1.2 * sheet.line_px
    reach = 0.7 * sheet.line_px
    return int((cover.area(np.hstack([at - reach, at + reach])) > 0).sum())


def _outside(edge: Edge, middle: Array) -> float:
    """Outward distance of an edge: downwards for x and z, to the left for y."""
    away = edge.at.mean(axis=0) - middle
    return float(-away[0] if edge.axis == 1 else away[1])


def _edge_points(box: Box, axis: int, places: Array, corner: tuple[int, int]) -> Array:
    others = [other for other in range(3) if other != axis]
    edge = np.tile(box[0], (len(places), 1))
    edge[:, axis] = places
    for other, end in zip(others, corner, strict=True):
        edge[:, other] = box[end][other]
    return edge


def _number(sheet: Sheet, axes: Any, edge: Edge) -> None:
    """Write the numbers of one edge outside it, and the axis name beyond the middle."""
    font, line = sheet.font_size, sheet.line_px
    if edge.axis == 1:
        axes.plot(*edge.at.T, color=FAINT, lw=0.8, zorder=4)
    for at, place in zip(edge.at, edge.places, strict=True):
        _write(axes, at + edge.out * 0.6 * line, f"{place:g}", edge.out,
               color=QUIET, fontsize=0.85 * font)  # fmt: skip
    digits = max(len(f"{place:g}") for place in edge.places)
    beyond = 1.6 + 0.45 * digits * abs(edge.out[0]) + 0.5 * abs(edge.out[1])
    centre = edge.at.mean(axis=0) + edge.out * beyond * line
    _write(axes, centre, NAMES[edge.axis], edge.out, color=INK, fontsize=font, style="italic")


def _write(axes: Any, at: Array, text: str, out: Array, **font: Any) -> None:
    letter = float(font["fontsize"]) * axes.figure.dpi / POINTS_PER_INCH
    across = "left" if out[0] > 0.5 else "right" if out[0] < -0.5 else "center"
    width = LETTER_WIDTH * letter * (len(text) + 0.5)
    share = {"left": 0.0, "center": 0.5, "right": 1.0}[across]
    room = np.array([[share * width, 0.7 * letter], [(1.0 - share) * width, 0.7 * letter]])
    at = np.clip(at, room[0] + 2.0, np.array(axes_size(axes)) - room[1] - 2.0)
    upright = "top" if out[1] > 0.5 else "bottom" if out[1] < -0.5 else "center"
    axes.text(*at, text, ha=across, va=upright, zorder=5, **font)
