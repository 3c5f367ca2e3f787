"""Placement of names beside their objects, without overlaps or clipping."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import INK, QUIET, Sheet
from recon.figures.cover import Cover

Array = NDArray[np.float64]

LETTER_WIDTH = 0.56
"""Mean width of a letter, relative to its height."""
NUM_AROUND = 16
RINGS = (0.0, 1.0, 2.0, 3.5, 5.5, 8.0)
"""Candidate distances of a name from its object, in lines of text."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Name:
    """A text, and the box (left, top, right, bottom) of its object in pixels, y down."""

    text: str
    box: Array


def place(
    names: Sequence[Name],
    sizes: Array,
    extent: Array,
    gap: float,
    cover: Cover | None = None,
    reserved: Sequence[Array] = (),
) -> Array:
    """Boxes (M, 4) for texts of `sizes` (M, 2) inside `extent` (4,), y down.

    Each name in turn takes the nearest position that covers nothing drawn, no object, no earlier
    name and no `reserved` box; if everything is covered, the position that covers the least.
    """
    taken = [*reserved, *([] if cover else [name.box for name in names])]
    placed = []
    for name, size in zip(names, sizes, strict=True):
        spots = _spots(name.box, size, gap)
        low, high = extent[:2], np.maximum(extent[2:] - size, extent[:2])
        spots = np.clip(spots, low, high)
        boxes = np.hstack([spots, spots + size])
        covered = _overlap(boxes, np.array(taken).reshape(-1, 4))
        if cover is not None:
            covered += cover.area(boxes)
        covered /= float(np.prod(size))
        away = np.linalg.norm(spots - spots[0], axis=1) / gap
        best = boxes[np.argmin(40.0 * covered + away)]
        placed.append(best)
        taken.append(best)
    return np.array(placed).reshape(-1, 4)


def _spots(box: Array, size: Array, gap: float) -> Array:
    """Upper left corners (S, 2), first straight above the box, then around it in rings."""
    middle, reach = (box[:2] + box[2:]) / 2.0, (box[2:] - box[:2]) / 2.0
    angles = np.linspace(0.0, 2.0 * np.pi, NUM_AROUND, endpoint=False)
    around = np.column_stack([np.sin(angles), -np.cos(angles)])
    stretched = around / np.abs(around).max(axis=1, keepdims=True)
    rings = [
        middle + stretched * (reach + size / 2.0 + 0.3 * gap + ring * gap) - size / 2.0
        for ring in RINGS
    ]
    return np.vstack(rings)


def _overlap(boxes: Array, others: Array) -> Array:
    """Area (S,) of each box's overlap with the others."""
    low = np.maximum(boxes[:, None, :2], others[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], others[None, :, 2:])
    area: Array = np.prod(np.maximum(high - low, 0.0), axis=2).sum(axis=1)
    return area


def text_sizes(sheet: Sheet, texts: Sequence[str]) -> Array:
    """Widths and heights (M, 2) of texts in pixels, including padding."""
    lines = [text.split("\n") for text in texts]
    width = [LETTER_WIDTH * sheet.line_px / 1.35 * max(map(len, line)) for line in lines]
    height = [0.95 * sheet.line_px * len(line) for line in lines]
    return np.column_stack([width, height]).reshape(-1, 2) + 0.6 * sheet.line_px


def write(
    sheet: Sheet,
    axes: Any,
    names: Sequence[Name],
    cover: Cover | None = None,
    reserved: Sequence[Array] = (),
) -> None:
    """Write names into settled axes, with a line to objects further away."""
    window = axes.get_window_extent()
    sizes = text_sizes(sheet, [name.text for name in names])
    extent = np.array([0.0, 0.0, window.width, window.height])
    boxes = place(names, sizes, extent, sheet.line_px, cover, reserved)
    for name, box in zip(names, boxes, strict=True):
        middle = (box[:2] + box[2:]) / 2.0
        nearest = np.clip(middle, name.box[:2], name.box[2:])
        on_edge = np.clip(nearest, box[:2], box[2:])
        if np.linalg.norm(on_edge - nearest) > 0.8 * sheet.line_px:
            line = to_data(axes, np.array([on_edge, nearest]))
            axes.plot(*line.T, color=QUIET, lw=0.7, zorder=8, scalex=False, scaley=False)
        axes.text(
            *to_data(axes, middle), name.text, ha="center", va="center", color=INK,
            fontsize=sheet.font_size, zorder=9, linespacing=1.05,
            bbox={"boxstyle": "round,pad=0.2", "fc": "white", "ec": "none", "alpha": 0.8},
        )  # fmt: skip


def to_data(axes: Any, at: Array) -> Array:
    """Data coordinates of pixels (..., 2) relative to the upper left corner of axes."""
    window = axes.get_window_extent()
    shown = np.array([window.x0, window.y1]) + at * (1.0, -1.0)
    data: Array = axes.transData.inverted().transform(shown)
    return data


def to_pixels(axes: Any, at: Array) -> Array:
    """Pixels (..., 2), relative to the upper left corner of axes, of data coordinates."""
    window = axes.get_window_extent()
    pixels: Array = (axes.transData.transform(at) - (window.x0, window.y1)) * (1.0, -1.0)
    return pixels
