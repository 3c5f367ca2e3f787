"""A figure as a file of a run folder, with the arrays that it shows."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.figures.canvas import Sheet, Size, Style, save
from recon.figures.kinds import Arrays, Kind, Subject
from recon.figures.table import KINDS
from recon.files import atomic_path

ALWAYS = ("solids", "overview", "map3d", "labels", "occupancy", "trajectory", "disparity")
"""Figures that every run with a map writes by default, those that take longest first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureRequest:
    """A request: which figures, and how they are drawn."""

    kind: str | None = None
    """None = all that can be drawn."""
    view: str = "default"
    size: Size | None = None
    """Pixels; if None, each kind's default, scaled with the style's dots per inch."""
    style: Style = field(default_factory=Style)
    ending: str = "png"
    with_data: bool = False
    """Also write the shown data as arrays, and the labels as maps."""


def write_run_figure(run_path: Path, subject: Subject, name: str) -> None:
    """Draw and write one figure of a run, and the arrays of its clearest pair if it shows them."""
    if subject.kept is not None and name == "disparity":
        write_arrays(run_path, name, {"kind": np.array(name), **subject.kept})
    write_figure(run_path, name, KINDS.load(name), subject, FigureRequest())


def write_figure(
    run_path: Path, stem: str, kind: Kind, subject: Subject, request: FigureRequest
) -> list[Path]:
    """Draw one figure into `figures/`; its name includes the view."""
    shown = (
        f"{stem}_{_as_name(request.view)}" if kind.has_view and request.view != "default" else stem
    )
    scale = request.style.dpi / Style().dpi
    size = request.size or (round(kind.size[0] * scale), round(kind.size[1] * scale))
    path = run_path / "figures" / f"{shown}.{request.ending}"
    path.parent.mkdir(exist_ok=True)
    try:
        figure = kind.draw(subject, Sheet.of(size, request.style, fits=request.size is None))
    except KeyError as error:
        raise InputError(f"{run_path}: the data for {stem} has no {error}") from error
    save(figure, path)
    paths = [path]
    if request.with_data:
        paths.append(write_arrays(run_path, shown, kind.data(subject)))
    return paths


def _as_name(view: str) -> str:
    """A view as part of a file's name."""
    return view.replace(",", "_").replace(" ", "")


def write_arrays(run_path: Path, name: str, arrays: Arrays) -> Path:
    """Write `figures/NAME.npz`, from which a figure can be redrawn."""
    path = run_path / "figures" / f"{name}.npz"
    path.parent.mkdir(exist_ok=True)
    with atomic_path(path) as part:
        np.savez_compressed(part, allow_pickle=False, **arrays)
    return path
