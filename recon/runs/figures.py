"""The figures of a run: drawn when it ends, and again from its folder."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.figures import map3d, topview
from recon.figures.canvas import Image, Size, save_png
from recon.figures.disparity import disparity
from recon.figures.overview import overview
from recon.figures.parts import SIZE as PARTS_SIZE
from recon.figures.parts import parts
from recon.figures.slices import SIZE as SLICES_SIZE
from recon.figures.slices import slices
from recon.records import Matches
from recon.runfolder import read_manifest
from recon.runs.contents import RunContents, read_contents


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """One kind of figure: how it is drawn and how large where nobody says."""

    draw: Callable[[RunContents, str, Size], Image]
    size: Size


KINDS = {
    "map3d": Kind(
        draw=lambda run, view, size: map3d.map3d(run.voxels, run.objects, view, size),
        size=map3d.SIZE,
    ),
    "solids": Kind(
        draw=lambda run, view, size: map3d.map3d(
            run.voxels, run.objects, view, size, with_solids=True
        ),
        size=map3d.SIZE,
    ),
    "parts": Kind(draw=lambda run, _, size: parts(run.voxels, run.objects, size), size=PARTS_SIZE),
    "counts": Kind(
        draw=lambda run, view, size: map3d.map3d(
            run.voxels, (), view, size, colours=map3d.by_value(np.log10(run.voxels.counts))
        ),
        size=map3d.SIZE,
    ),
    "slices": Kind(draw=lambda run, _, size: slices(run.voxels, size), size=SLICES_SIZE),
    "occupancy": Kind(
        draw=lambda run, _, size: topview.occupancy(run.voxels, size), size=topview.SIZE
    ),
    "labels": Kind(
        draw=lambda run, _, size: topview.labels(
            run.voxels, run.objects, run.trajectory.positions, size
        ),
        size=topview.SIZE,
    ),
    "trajectory": Kind(
        draw=lambda run, _, size: topview.path(run.trajectory.T_world_left, run.voxels, size),
        size=topview.SIZE,
    ),
}


ALWAYS = ("map3d", "solids", "occupancy", "labels", "trajectory")
"""What every run leaves without being asked."""


def draw_always(contents: RunContents) -> dict[str, Image]:
    """The figures that every run leaves, by name."""
    return {name: KINDS[name].draw(contents, "default", KINDS[name].size) for name in ALWAYS}


def add_pair(pictures: dict[str, Image], left: Image, matches: Matches) -> dict[str, Image]:
    """The pictures, with the disparity of the clearest pair and a sheet of them all."""
    drawn = disparity(left, matches)
    sheet = {
        "The map, with what was found": pictures["map3d"],
        "What the left eye saw": left,
        "What was matched": drawn,
        "The floor, with names": pictures["labels"],
    }
    return pictures | {"disparity": drawn, "overview": overview(sheet)}


def write_figures(run_path: Path, pictures: dict[str, Image]) -> list[Path]:
    """Write `figures/NAME.png` for every picture; return their paths."""
    (run_path / "figures").mkdir(exist_ok=True)
    paths = [run_path / "figures" / f"{name}.png" for name in pictures]
    for path, image in zip(paths, pictures.values(), strict=True):
        save_png(image, path)
    return paths


def figure_run(
    run_path: Path, *, kind: str | None = None, view: str = "default", size: Size | None = None
) -> list[Path]:
    """Draw one kind of figure of a run, or all, into its folder.

    Raises
    ------
    InputError
        For a kind or view that is not known, and for a folder that is no run.
    """
    if kind is not None and kind not in KINDS:
        raise InputError(f"kind is {kind!r}, but one of {', '.join(KINDS)} is needed")
    read_manifest(run_path)
    contents = read_contents(run_path)
    pictures = {
        name: KINDS[name].draw(contents, view, size or KINDS[name].size)
        for name in ([kind] if kind else KINDS)
    }
    return write_figures(run_path, pictures)
