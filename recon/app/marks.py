"""SVG overlays of an image."""

from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import scales

Array = NDArray[np.float64]

BAR = (1.1, 14.0)
"""Width and height of a scale, relative to its font size."""
EYE_FONT = 8.5
"""Font size of a scale in pixels, in a camera's pane."""
STEPS = 32


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
    length = scales.round_length(0.25 * width / unit_px)
    font = 0.028 * width
    right, low = width - 0.8 * font, height - 0.7 * font
    line = np.array([[right - length * unit_px, low, 1.0], [right, low, 1.0]])
    middle = right - 0.5 * length * unit_px
    words = text(middle, low - 0.5 * font, f"{length:g} units", font)
    return polyline(line, "#16191d", 4.0) + polyline(line, "#ffffff", 2.0) + words


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
    is_whole = bool(np.all(values[np.isfinite(values)] % 1.0 == 0.0))
    ends = ((0.0, high), (0.5, (low + high) / 2.0), (1.0, low))
    words = [
        text(1.6 * font + width, 2.8 * font + share * tall, _number(value, is_whole), font, "start")
        for share, value in ends
    ]
    return "".join([*blocks, *words, text(font, 1.4 * font, label, font, "start")])


def _number(value: float, is_whole: bool) -> str:
    return f"{value:.0f}" if is_whole else f"{value:.3g}"
