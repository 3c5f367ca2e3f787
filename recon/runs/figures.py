"""The figures of a run, drawn when it ends or later from its folder."""

import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.formats import holds_mesh, read_mesh
from recon.figures.kept import kept_pair
from recon.figures.kinds import Arrays, Kind, Subject
from recon.figures.table import KINDS
from recon.manifest import read_manifest
from recon.records import Mesh, Reconstruction
from recon.runs.figure_file import (
    ALWAYS,
    FigureRequest,
    write_arrays,
    write_figure,
    write_run_figure,
)
from recon.runs.labels import write_labels
from recon.runs.maps import map_path
from recon.runs.reading import is_recorded, read_reconstruction, unit_of_run

if TYPE_CHECKING:
    from recon.mapping.mapper import Step
    from recon.runs.work import Work

PAIRED = ("disparity", "overview")
"""Figures that show the pair with the most matches, if there is one."""
NAMELESS = ("occupancy", "trajectory", "disparity")
"""Those of `ALWAYS` that show no objects."""
PLANS = ("overview", "labels")
"""Those of `ALWAYS` that show the states of the floor."""
DAMAGE = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile)


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
    kept = None
    if clearest is not None:
        kept = kept_pair(clearest.pair.left, clearest.matches.probable())
    subject = replace(_subject(work.run.path, contents), kept=kept)
    # Found here, the floor is found once, and what draws it needs neither map nor compiled loops.
    floor = subject.states if set(names) & set(PLANS) else None
    shown = replace(subject, floor=floor, run=replace(contents, map=None))
    for name in names:
        if kept is not None or name not in PAIRED:
            work.artist.draw(write_run_figure, work.run.path, shown, name)


def leave_figure(run_path: Path, kind: str, arrays: Arrays, name: str | None = None) -> None:
    """Write a figure, and `figures/NAME.npz`, from which it can be redrawn."""
    name = name or kind
    write_arrays(run_path, name, {"kind": np.array(kind), **arrays})
    write_figure(run_path, name, KINDS.load(kind), Subject(kept=arrays), FigureRequest())


def leave_mesh_figure(run_path: Path, surface: Mesh, cameras: NDArray[np.float64]) -> None:
    """Draw a run's mesh, seen from its cameras (N, 3)."""
    subject = replace(_subject(run_path, None), mesh=surface, cameras=cameras)
    write_figure(run_path, "mesh", KINDS.load("mesh"), subject, FigureRequest())


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
            paths += write_figure(run_path, stem, kind, subject, request)
            if request.with_data and stem == "labels":
                paths += write_labels(run_path / "figures", subject)
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
        file = run_path / "mesh.ply"
        has_mesh = file.exists() and holds_mesh(file)
        found = [(name, _with_mesh(run_path, request.view))] if has_mesh else []
        lack = f"has no mesh.ply with triangles, which {name} shows"
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
