"""The pairs of a run with a slider: what the left camera saw, and its disparity."""

from collections.abc import Callable
from typing import Any

from recon.app.drawing import as_source
from recon.app.exhibit import Exhibit
from recon.app.painter import Painter
from recon.app.pairs import Pairs, SeenPair, with_disparity
from recon.app.widgets import nicegui, note, slider, testid


class PairViewer:
    """A slider over the pairs, with both images of the one that is chosen."""

    def __init__(
        self, exhibit: Exhibit, suffix: str, chosen: Callable[[int], Any], complain: Any
    ) -> None:
        ui = nicegui()
        self.pairs = Pairs(exhibit)
        self.number = 0
        self.count = 0 if exhibit.trajectory is None else len(exhibit.trajectory)
        self._chosen = chosen
        self.label = note(text=self._text())
        slider(f"trajectory-slider{suffix}", (0, max(self.count - 1, 1), 1), 0, self._choose)
        with ui.element("div").classes("recon-panes w-full"):
            self.left = testid(ui.image().classes("w-full recon-pane"), f"pair-left{suffix}")
            self.disparity = testid(
                ui.image().classes("w-full recon-pane"), f"pair-disparity{suffix}"
            )
        self.painter: Painter[SeenPair] = Painter(self._take, self._show, complain)
        if exhibit.is_run:
            self.painter.ask()

    def _text(self) -> str:
        return f"pair {self.number} of {self.count}" if self.count else "no trajectory"

    def _choose(self, value: float) -> None:
        self.number = min(round(value), max(self.count - 1, 0))
        self.label.set_text(self._text())
        self._chosen(self.number)
        self.painter.ask()

    def _take(self) -> SeenPair:
        return self.pairs.take(self.number)

    def _show(self, seen: SeenPair) -> None:
        self.left.set_source(as_source(seen.left, ".jpg"))
        self.disparity.set_source(as_source(with_disparity(seen), ".jpg"))
        number = len(seen.arrays["disparity_px"])
        self.label.set_text(f"{self._text()}: {number:,} matched points")
