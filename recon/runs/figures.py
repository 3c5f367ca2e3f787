"""The figures of a run, drawn when it ends or later from its folder."""

import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.formats import read_mesh
from recon.figures.canvas import Sheet, Size, Style, save
from recon.figures.kept import kept_pair
from recon.figures.kinds import Arrays, Kind, Subject
from recon.figures.table import KINDS
from recon.files import atomic_path
from recon.manifest import read_manifest
from recon.records import Mesh, Reconstruction
from recon.runs.labels import write_labels
from recon.runs.maps import map_path
from recon.runs.reading import is_recorded, read_reconstruction, unit_of_run

if TYPE_CHECKING:
    from recon.mapping.mapper import Step
    from recon.runs.work import Work

PAIRED = ("disparity", "overview")
"""Figures that show the pair with the most matches, if there is one."""
ALWAYS = ("overview", "map3d", "solids", "labels", "occupancy", "trajectory", "disparity")
"""Figures that every run with a map writes by default, those that take longest first."""
NAMELESS = ("occupancy", "trajectory", "disparity")
"""Those of them that show no objects."""
DAMAGE = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile)


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


def draw_run_figures(
    work: "Work", contents: Reconstruction, clearest: "Step | None", names: Sequence[str] = ALWAYS
) -> None:
    """Request figures of a run with a map from its artist.

    Parameters
    ----------
    work : Work
    contents : Reconstruction
    clearest : Step, optional
        The step with the most matches; without it, there are no figures of a pair.
    names : sequence of str
        Their kinds, in the order of drawing.
    """
    kept = None if clearest is None else kept_pair(clearest.pair.left, clearest.matches)
    shown = _drawable(contents)
    for name in names:
        if kept is not None or name not in PAIRED:
            work.artist.draw(write_run_figure, work.run.path, shown, kept, name)


def write_run_figure(
    run_path: Path, contents: Reconstruction, kept: Arrays | None, name: str
) -> None:
    """Draw and write one figure of a run, and the arrays of its clearest pair if it shows them."""
    subject = replace(_subject(run_path, contents), kept=kept)
    if kept is not None and name == "disparity":
        _write_arrays(run_path, name, {"kind": np.array(name), **kept})
    _write(run_path, name, KINDS.load(name), subject, FigureRequest())


def _drawable(contents: Reconstruction[Any]) -> Reconstruction[Any]:
    """The part of a result that figures show, small to send: the map only if it has rays."""
    has_rays = "rays" in getattr(contents.map, "channels", ())
    return contents if has_rays else replace(contents, map=None)


def leave_figure(run_path: Path, kind: str, arrays: Arrays, name: str | None = None) -> None:
    """Write a figure, and `figures/NAME.npz`, from which it can be redrawn."""
    name = name or kind
    _write_arrays(run_path, name, {"kind": np.array(kind), **arrays})
    _write(run_path, name, KINDS.load(kind), Subject(kept=arrays), FigureRequest())


def leave_mesh_figure(run_path: Path, surface: Mesh, cameras: NDArray[np.float64]) -> None:
    """Draw a run's mesh, seen from its cameras (N, 3)."""
    subject = replace(_subject(run_path, None), mesh=surface, cameras=cameras)
    _write(run_path, "mesh", KINDS.load("mesh"), subject, FigureRequest())


def figure_run(run_path: Path, request: FigureRequest | None = None) -> list[Path]:
    """Draw one kind of figure of a run, or all possible ones, into its folder.

    Returns
    -------
    list of Path
        The written files.

    Raises
    ------
    InputError
        For an unknown kind or view, for one that cannot be drawn from the run, and for a folder
        that is not a run.
    """
    request = request or FigureRequest()
    read_manifest(run_path)
    kinds = [request.kind] if request.kind else KINDS.names()
    paths: list[Path] = []
    for name in kinds:
        kind = KINDS.load(name)
        if request.kind and request.view != "default" and not kind.has_view:
            raise InputError(f"view is {request.view!r}, but {name} has a fixed view")
        for stem, subject in _subjects(run_path, name, kind, request):
            paths += _write(run_path, stem, kind, subject, request)
    if not paths:
        raise InputError(f"{run_path} contains nothing that a figure could show")
    return paths


def _subjects(
    run_path: Path, name: str, kind: Kind, request: FigureRequest
) -> Iterator[tuple[str, Subject]]:
    """Subjects of a run for figures of one kind, by the name of the file."""
    if kind.is_kept:
        found = list(_kept_subjects(run_path, name, request))
        lack = f"has no data for the figure {name}"
    elif kind.needs_mesh:
        has_mesh = (run_path / "mesh.ply").exists()
        found = [(name, _with_mesh(run_path, request.view))] if has_mesh else []
        lack = f"has no mesh.ply, which {name} shows"
    else:
        return (yield from _mapped_subjects(run_path, name, kind, request))
    if request.kind and not found:
        raise InputError(f"{run_path} {lack}")
    yield from found


def _mapped_subjects(
    run_path: Path, name: str, kind: Kind, request: FigureRequest
) -> Iterator[tuple[str, Subject]]:
    if request.kind is None and map_path(run_path) is None:
        return
    subject = _subject(run_path, read_reconstruction(run_path), request.view)
    lack = kind.lack(subject)
    if lack is None:
        yield name, subject
    elif request.kind:
        raise InputError(f"{run_path}: {lack}")


def _with_mesh(run_path: Path, view: str) -> Subject:
    run = read_reconstruction(run_path) if map_path(run_path) is not None else None
    cameras = None if run is None else run.trajectory.positions
    subject = _subject(run_path, run, view)
    return replace(subject, mesh=read_mesh(run_path / "mesh.ply"), cameras=cameras)


def _kept_subjects(
    run_path: Path, name: str, request: FigureRequest
) -> Iterator[tuple[str, Subject]]:
    # The overview shows the run's disparity beside its map.
    source = "disparity" if name == "overview" else name
    has_map = map_path(run_path) is not None
    if name == "overview" and not has_map:
        return
    for path in sorted((run_path / "figures").glob("*.npz")):
        arrays = read_arrays(path)
        if str(arrays.get("kind")) == source:
            run = read_reconstruction(run_path) if has_map else None
            subject = replace(_subject(run_path, run, request.view), kept=arrays)
            yield (name, subject) if name == "overview" else (path.stem, subject)


def _subject(run_path: Path, run: Reconstruction[Any] | None, view: str = "default") -> Subject:
    return Subject(
        run=run,
        unit=unit_of_run(run_path),
        is_recorded=is_recorded(run_path),
        asked_view=view,
    )


def _write(
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
        paths.append(_write_arrays(run_path, shown, kind.data(subject)))
        if stem == "labels":
            paths += write_labels(run_path / "figures", subject)
    return paths


def _as_name(view: str) -> str:
    """A view as part of a file's name."""
    return view.replace(",", "_").replace(" ", "")


def _write_arrays(run_path: Path, name: str, arrays: Arrays) -> Path:
    path = run_path / "figures" / f"{name}.npz"
    path.parent.mkdir(exist_ok=True)
    with atomic_path(path) as part:
        np.savez_compressed(part, allow_pickle=False, **arrays)
    return path


def read_arrays(path: Path) -> Arrays:
    """The arrays of a figure.

    Raises
    ------
    InputError
        If the file is damaged.
    """
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except DAMAGE as error:
        raise InputError(
            f"{path} cannot be read ({error}); it is not an archive of arrays"
        ) from error
