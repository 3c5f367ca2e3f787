"""The sheet that figures are drawn on, and its reproducible output to a file."""

import importlib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.files import atomic_path
from recon.libraries import load_pyvista

Image = NDArray[np.uint8]
Size = tuple[int, int]
"""Width and height in pixels at DPI."""
Background = Literal["white", "transparent"]

DPI = 100
INK = "#22262b"
QUIET = "#6f767d"
FAINT = "#c3c8cd"
ACCENT = "#b3391f"
SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Okabe and Ito's colours, distinguishable with any colour vision."""
FORMATS = ("png", "pdf", "svg")

FONT_SHARE = 0.0135
"""Default font size, as a share of the sheet's mean side."""
SMALLEST_FONT = 6.5
"""Points; smaller print is illegible."""
POINTS_PER_INCH = 72.0
PNG = {"compress_level": 3}
"""Writes a file a fifteenth larger than the default of 6, in half the time."""
LOWEST = 0.4
"""A sheet keeps at least this share of its height."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """The look of a figure, independent of its content."""

    dpi: int = DPI
    font_size: float | None = None
    """Points; in proportion to the sheet if None."""
    with_title: bool = True
    background: Background = "white"


class Sheet:
    """A matplotlib figure, or a panel of one, with the common fonts and lines.

    Parameters
    ----------
    figure : matplotlib Figure or SubFigure
    style : Style
    font_size : float
        Points.
    fits : bool
        The sheet may be lower than its size, if its content is.
    """

    def __init__(self, figure: Any, style: Style, font_size: float, *, fits: bool = False) -> None:
        self.figure = figure
        self.style = style
        self.font_size = font_size
        self.fits = fits

    @classmethod
    def of(cls, size: Size, style: Style | None = None, *, fits: bool = False) -> "Sheet":
        """An empty sheet of `size` pixels at the style's dots per inch."""
        from recon.figures.notebook import ShownFigure

        style = style or Style()
        inches = size[0] / style.dpi, size[1] / style.dpi
        clear = style.background == "transparent"
        figure = ShownFigure(
            figsize=inches, dpi=style.dpi, layout="constrained",
            facecolor="none" if clear else "white",
        )  # fmt: skip
        font = FONT_SHARE * POINTS_PER_INCH * float(np.sqrt(inches[0] * inches[1]))
        return cls(figure, style, style.font_size or max(font, SMALLEST_FONT), fits=fits)

    @property
    def size(self) -> Size:
        """Width and height in pixels."""
        box = self.figure.bbox
        return max(round(box.width), 1), max(round(box.height), 1)

    @property
    def line_px(self) -> float:
        """Height of a line of text in pixels."""
        return 1.35 * self.font_size * self.style.dpi / POINTS_PER_INCH

    def place_by_hand(self) -> None:
        """Keep axes where they are placed; a sheet of panels still arranges the others."""
        from matplotlib.figure import Figure

        if isinstance(self.figure, Figure):
            self.figure.set_layout_engine("none")

    def settle(self) -> None:
        """Run the layout, so that axes have their position in pixels."""
        _lay_out(self.figure.get_figure(root=True))
        for axes in self.figure.axes:
            axes.apply_aspect()

    def trim(self, axes: Any) -> None:
        """Fit a sheet with nothing more to draw; a panel is arranged with its sheet."""
        if self.fits:
            self.fit(axes)

    def fit(self, axes: Any) -> None:
        """Settle the only axes of a sheet, without the margins that an equal scale leaves above
        and below, if allowed; what is drawn later does not move them.
        """
        self.settle()
        spare = axes.get_position(original=True).height - axes.get_position().height
        if self.fits and spare * self.size[1] > 1.0:
            width, height = self.figure.get_size_inches()
            self.figure.set_size_inches(width, height * max(1.0 - spare, LOWEST))
            self.settle()
        self.place_by_hand()

    def panels(
        self, rows: int, columns: int, *, font_share: float = 1.0, **ratios: Any
    ) -> NDArray[np.object_]:
        """Sheets (rows, columns) side by side on this one, with fonts scaled by `font_share`."""
        grid = self.figure.subfigures(rows, columns, squeeze=False, **ratios)
        for panel in grid.flat:
            panel.set_facecolor("none")
        sheets = [Sheet(panel, self.style, font_share * self.font_size) for panel in grid.flat]
        return np.array(sheets, dtype=object).reshape(rows, columns)

    def axes(self, title: str = "", xlabel: str = "", ylabel: str = "", at: Any = 111) -> Any:
        """Axes with a title, unless the style has none, and thin lines."""
        axes = self.figure.add_subplot(*np.atleast_1d(at).tolist())
        self.dress(axes, title)
        axes.set_xlabel(xlabel, color=INK, fontsize=self.font_size)
        axes.set_ylabel(ylabel, color=INK, fontsize=self.font_size)
        return axes

    def dress(self, axes: Any, title: str = "") -> None:
        """Give axes the common fonts and lines."""
        axes.set_facecolor("none" if self.style.background == "transparent" else "white")
        if title and self.style.with_title:
            axes.set_title(title, color=INK, fontsize=1.1 * self.font_size, loc="left")
        axes.tick_params(colors=QUIET, labelcolor=INK, labelsize=0.9 * self.font_size)
        for spine in axes.spines.values():
            spine.set_color(FAINT)

    def colour_bar(self, coloured: Any, axes: Any, label: str, **placed: Any) -> Any:
        """Add a colour bar beside the axes, as high as they are."""
        thick = 0.7 * self.line_px / axes.get_window_extent().width
        place = axes.inset_axes((1.0 + thick, 0.0, thick, 1.0))
        bar = self.figure.colorbar(coloured, cax=place, **placed)
        self.dress_bar(bar, label)
        return bar

    def dress_bar(self, bar: Any, label: str) -> None:
        """Give a colour bar the common fonts and lines."""
        bar.set_label(label, color=INK, fontsize=self.font_size)
        bar.ax.tick_params(colors=QUIET, labelcolor=INK, labelsize=0.9 * self.font_size)
        bar.outline.set_edgecolor(FAINT)


def load_libraries() -> None:
    """Load everything that is needed to draw, which takes as long as some figures."""
    importlib.import_module("matplotlib.figure")
    importlib.import_module("matplotlib.backends.backend_agg")
    getattr(load_pyvista(), "Plotter")  # noqa: B009


@contextmanager
def unwarned() -> Iterator[None]:
    """No warnings of matplotlib: characters that the font lacks are drawn as boxes, and text too
    large for its sheet covers what is beside it.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from font")
        warnings.filterwarnings("ignore", "constrained_layout not applied")
        yield


@unwarned()
def pixels(figure: Any) -> Image:
    """The pixels (H, W, 3) of a figure, over white."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    rgba = np.asarray(canvas.buffer_rgba()).astype(np.float64)
    alpha = rgba[..., 3:] / 255.0
    flat: Image = np.rint(rgba[..., :3] * alpha + 255.0 * (1.0 - alpha)).astype(np.uint8)
    return flat


@unwarned()
def save(figure: Any, path: Path) -> None:
    """Write a figure atomically, in the format of the suffix, without date or program name.

    Raises
    ------
    InputError
        For a suffix that is not one of FORMATS.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise InputError(f"{path}: {kind!r} is not a format, but {', '.join(FORMATS)} are")
    nameless = {
        "png": {"Software": None},
        "pdf": {"Creator": None, "Producer": None, "CreationDate": None},
        "svg": {"Creator": None, "Date": None},
    }[kind]
    # Journals refuse Type 3 fonts; the ids of an SVG are random without a salt.
    with rc_context({"pdf.fonttype": 42, "svg.hashsalt": "recon"}), atomic_path(path) as part:
        _lay_out(figure)
        # The layout takes longer than the drawing, and would run again for every pass.
        figure.set_layout_engine("none")
        if kind == "png":
            canvas: Any = FigureCanvasAgg(figure)
            canvas.print_png(part, metadata=nameless, pil_kwargs=PNG)
        else:
            figure.savefig(part, format=kind, metadata=nameless)


@unwarned()
def _lay_out(figure: Any) -> None:
    """Run the layout of a figure, unless its axes are placed."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
