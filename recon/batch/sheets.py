"""The figures of a batch: a contact sheet, a confusion matrix, and a plot per metric of a sweep."""

import importlib
import re
import threading
from collections.abc import Sequence
from pathlib import Path

from recon.batch.batch import BatchReport
from recon.batch.sweeps import Point, curves
from recon.batch.worker import Outcome
from recon.figures.canvas import save
from recon.figures.confusion import confusion_matrix
from recon.figures.contact import Print, contact, thumbnail
from recon.figures.sweep import sweep

SHOWN = ("overview", "confusion", "labels", "map3d", "disparity", "dense", "mesh")
"""Figures that represent a run, in order of preference."""


def load_ahead() -> None:
    """Load the drawing libraries in a thread while the jobs run."""
    names = "matplotlib.figure", "matplotlib.backends.backend_agg"
    threading.Thread(target=lambda: [*map(importlib.import_module, names)], daemon=True).start()


def print_of(outcome: Outcome, folder: Path) -> Print:
    """The entry of a job in the contact sheet of a batch in a folder."""
    figure = _figure(folder / outcome.name)
    image = None if figure is None else thumbnail(figure)
    return Print(name=outcome.name, image=image, note=outcome.error or outcome.state)


def write_sheets(
    report: BatchReport, points: Sequence[Point], metrics: Sequence[str], prints: Sequence[Print]
) -> None:
    """Write `contact.png`, `confusion.png` if truth is known, and `sweep_METRIC.png`."""
    save(contact(prints), report.folder / "contact.png")
    named = [name for one in report.outcomes for name in one.names]
    if named:
        figure = confusion_matrix([true for true, _ in named], [found for _, found in named])
        save(figure, report.folder / "confusion.png")
    for metric in metrics if points else ():
        setting, runs = curves(points, metric)
        figure = sweep(runs, setting, metric)
        save(figure, report.folder / f"sweep_{re.sub(r'[^A-Za-z0-9_]+', '_', metric)}.png")


def _figure(run: Path) -> Path | None:
    """The image that represents a run."""
    found = [run / "figures" / f"{name}.png" for name in SHOWN]
    others = sorted((run / "figures").glob("*.png"))
    return next((path for path in [*found, *others] if path.is_file()), None)
