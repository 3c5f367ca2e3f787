"""The pairs of a run with a slider: the left image, and its matches."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.app import marks
from recon.app.exhibit import Exhibit
from recon.app.painter import Painter
from recon.app.pairs import SHOWN, SPARSE, Pairs, SeenPair
from recon.app.source import as_source
from recon.app.widgets import chooser, nicegui, note, slider, testid
from recon.figures import scales
from recon.records import as_rgb

DIM = 0.45
DOT_PX = 1
FONT = 0.034
"""Font size of the scale, relative to the image's width."""


class PairViewer:
    """A slider over the pairs, with both images of the chosen one."""

    def __init__(
        self, exhibit: Exhibit, suffix: str, chosen: Callable[[int], Any], complain: Any
    ) -> None:
        ui = nicegui()
        self.pairs = Pairs(exhibit)
        self.number = 0
        self.shown = SPARSE
        self.count = 0 if exhibit.trajectory is None else len(exhibit.trajectory)
        self._chosen, self._complain = chosen, complain
        self.label = note(words=self._text(self.number))
        slider(f"trajectory-slider{suffix}", (0, max(self.count - 1, 1), 1), 0, self._choose)
        chooser(f"pair-shown{suffix}", "shown in it", SHOWN, SPARSE, self._show_other)
        with ui.element("div").classes("recon-stack w-full recon-seen"):
            self.left, self.disparity = (
                testid(ui.interactive_image(sanitize=False).classes("w-full recon-pane"), name)
                for name in (f"pair-left{suffix}", f"pair-disparity{suffix}")
            )
        self.painter: Painter[tuple[int, SeenPair]] = Painter(self._take, self._show, self._fail)
        self._is_begun = not exhibit.is_run
        if not exhibit.is_run:
            self.label.set_text("a file holds no pairs")

    def begin(self) -> None:
        """Show the first pair, if not done yet."""
        if not self._is_begun:
            self._is_begun = True
            self._ask()

    def _text(self, number: int) -> str:
        if self.count < 2:
            return f"pair {number}, the only one" if self.count else "no trajectory"
        return f"pair {number} (0 to {self.count - 1})"

    def _choose(self, value: float) -> None:
        self.number = min(round(value), max(self.count - 1, 0))
        self._chosen(self.number)
        self._ask()

    def _show_other(self, shown: str) -> None:
        self.shown = shown
        self._ask()

    def _ask(self) -> None:
        self.label.set_text(f"{self._text(self.number)}: finding {self.shown} ...")
        self.painter.ask()

    def _take(self) -> tuple[int, SeenPair]:
        number = self.number
        return number, self.pairs.take(number, self.shown)

    def _fail(self, text: str) -> None:
        self.label.set_text(self._text(self.number))
        self._complain(text)

    def _show(self, taken: tuple[int, SeenPair]) -> None:
        number, seen = taken
        self.left.set_source(as_source(seen.left, ".jpg"))
        self.disparity.set_source(as_source(coloured(seen), ".jpg"))
        font = FONT * seen.left.shape[1]
        self.disparity.set_content(
            marks.scale(seen.values, seen.label, scales.disparity(), font)
            if len(seen.values)
            else ""
        )
        self.label.set_text(f"{self._text(number)}: {seen.said}")


def coloured(seen: SeenPair) -> NDArray[np.uint8]:
    """The dimmed left image (H, W, 3) with every point in the colour of its value."""
    image = as_rgb(np.asarray(DIM * as_rgb(seen.left).mean(axis=2), np.uint8))
    if not len(seen.values):
        return image
    scale = scales.coloured(seen.values, scales.disparity())
    colours = scales.rgb(scale, seen.values)
    height, width = image.shape[:2]
    u, v = np.rint(seen.points_px).astype(int).T
    reach = 0 if seen.is_dense else DOT_PX
    for down in range(-reach, reach + 1):
        for right in range(-reach, reach + 1):
            rows, columns = np.clip(v + down, 0, height - 1), np.clip(u + right, 0, width - 1)
            image[rows, columns] = colours
    return image
