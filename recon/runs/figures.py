"""The figures of a run: drawn when it ends, and again from its folder."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.figures import map3d, topview
from recon.figures.canvas import Image, Size, save_png
from recon.figures.disparity import disparity
from recon.figures.overview import overview
from recon.figures.parts import SIZE as PARTS_SIZE
from recon.figures.parts import parts
from recon.figures.slices import SIZE as SLICES_SIZE
from recon.figures.slices import slices
from recon.files import atomic_path
from recon.mapping.mapper import Step
from recon.records import Reconstruction
from recon.runfolder import read_manifest
from recon.runs.reading import read_reconstruction
from recon.voxelmap.ground import height_sum
from recon.voxelmap.weights import Weights

Data = dict[str, NDArray[np.generic]]


def _cells(run: Reconstruction) -> Data:
    kept = ("index", "means", "counts", "colours", "weights")
    values = {name: getattr(run.voxels, name) for name in kept}
    return {name: value for name, value in values.items() if value is not None}


def _solids(run: Reconstruction) -> Data:
    return _cells(run) | {
        "label": np.array([found.label for found in run.objects], dtype=np.str_),
        "probability": np.array([found.probability or 0.0 for found in run.objects]),
        "centre": np.array([found.centre for found in run.objects]).reshape(-1, 3),
        "size": np.array([found.size for found in run.objects]).reshape(-1, 3),
    }


def _floor(run: Reconstruction) -> Data:
    floor = height_sum(run.voxels)
    return {"cells": floor.cells, "origin_xz": floor.origin_xz}


def _way(run: Reconstruction) -> Data:
    return {"stamps_s": run.trajectory.stamps_s, "T_world_left": run.trajectory.T_world_left}


def _sigma(run: Reconstruction) -> NDArray[np.float64]:
    """(K,) the sigma, in cells, that points of a cell's mean weight have."""
    if run.voxels.weights is None:
        raise InputError('the map keeps no weights; make it with map.occupancy = ["weight"]')
    mean = np.clip(run.voxels.weights / run.voxels.counts, 1e-9, 1.0)
    sigma: NDArray[np.float64] = Weights.SIGMA_OF_HALF * np.sqrt(1.0 / mean - 1.0)
    return sigma


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """One kind of figure: how it is drawn and how large where nobody says."""

    draw: Callable[[Reconstruction, str, Size], Image]
    size: Size
    data: Callable[[Reconstruction], Data]
    """The arrays that are drawn, by name."""
    needs_weights: bool = False
    """Whether the map must keep weights (the rule `weight` of map.occupancy)."""


KINDS = {
    "map3d": Kind(
        draw=lambda run, view, size: map3d.map3d(run.voxels, run.objects, view, size),
        size=map3d.SIZE,
        data=_solids,
    ),
    "solids": Kind(
        draw=lambda run, view, size: map3d.map3d(
            run.voxels, run.objects, view, size, with_solids=True
        ),
        size=map3d.SIZE,
        data=_solids,
    ),
    "parts": Kind(
        draw=lambda run, _, size: parts(run.voxels, run.objects, size),
        size=PARTS_SIZE,
        data=_solids,
    ),
    "counts": Kind(
        draw=lambda run, view, size: map3d.map3d(
            run.voxels, (), view, size, colours=map3d.by_value(np.log10(run.voxels.counts))
        ),
        size=map3d.SIZE,
        data=_cells,
    ),
    "sigma": Kind(
        draw=lambda run, view, size: map3d.map3d(
            run.voxels, (), view, size, colours=map3d.by_value(_sigma(run), "cividis")
        ),
        size=map3d.SIZE,
        data=lambda run: _cells(run) | {"sigma_cells": _sigma(run)},
        needs_weights=True,
    ),
    "slices": Kind(
        draw=lambda run, _, size: slices(run.voxels, size), size=SLICES_SIZE, data=_cells
    ),
    "occupancy": Kind(
        draw=lambda run, _, size: topview.occupancy(run.voxels, size),
        size=topview.SIZE,
        data=_floor,
    ),
    "labels": Kind(
        draw=lambda run, _, size: topview.labels(
            run.voxels, run.objects, run.trajectory.positions, size
        ),
        size=topview.SIZE,
        data=_solids,
    ),
    "trajectory": Kind(
        draw=lambda run, _, size: topview.path(run.trajectory.T_world_left, run.voxels, size),
        size=topview.SIZE,
        data=_way,
    ),
}


ALWAYS = ("map3d", "solids", "occupancy", "labels", "trajectory")
"""What every run leaves without being asked."""


def draw_always(contents: Reconstruction) -> dict[str, Image]:
    """The figures that every run leaves, by name."""
    return {name: KINDS[name].draw(contents, "default", KINDS[name].size) for name in ALWAYS}


def add_pair(images: dict[str, Image], step: Step) -> dict[str, Image]:
    """The images, with the disparity of a step and a sheet of them all."""
    drawn = disparity(step.pair.left, step.matches)
    sheet = {
        "The map, with what was found": images["map3d"],
        "What the left eye saw": step.pair.left,
        "What was matched": drawn,
        "The floor, with names": images["labels"],
    }
    return images | {"disparity": drawn, "overview": overview(sheet)}


def write_run_figures(run_path: Path, contents: Reconstruction, clearest: Step | None) -> None:
    """Draw and write what every run leaves; `clearest` is the step with most matches."""
    images = draw_always(contents)
    if clearest is not None:
        images = add_pair(images, clearest)
    write_figures(run_path, images)


def write_figures(run_path: Path, images: dict[str, Image]) -> list[Path]:
    """Write `figures/NAME.png` for every image; return their paths."""
    (run_path / "figures").mkdir(exist_ok=True)
    paths = [run_path / "figures" / f"{name}.png" for name in images]
    for path, image in zip(paths, images.values(), strict=True):
        save_png(image, path)
    return paths


def write_data(run_path: Path, name: str, data: Data) -> Path:
    """Write `figures/NAME.npz`, the arrays that the figure shows."""
    path = run_path / "figures" / f"{name}.npz"
    with atomic_path(path) as part:
        np.savez_compressed(part, allow_pickle=False, **data)
    return path


def figure_run(
    run_path: Path,
    *,
    kind: str | None = None,
    view: str = "default",
    size: Size | None = None,
    with_data: bool = False,
) -> list[Path]:
    """Draw one kind of figure of a run, or all that its map allows, into its folder.

    Raises
    ------
    InputError
        For a kind or view that is not known, and for a folder that is no run.
    """
    if kind is not None and kind not in KINDS:
        raise InputError(f"kind is {kind!r}, but one of {', '.join(KINDS)} is needed")
    read_manifest(run_path)
    contents = read_reconstruction(run_path)
    has_weights = contents.voxels.weights is not None
    wanted = [kind] if kind else [k for k in KINDS if has_weights or not KINDS[k].needs_weights]
    images = {k: KINDS[k].draw(contents, view, size or KINDS[k].size) for k in wanted}
    paths = write_figures(run_path, images)
    if with_data:
        paths += [write_data(run_path, k, KINDS[k].data(contents)) for k in wanted]
    return paths
