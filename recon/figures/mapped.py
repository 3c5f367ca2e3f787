"""The kinds of figures drawn from a run's map."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.figures import map3d, mesh, occupancy, parts, slices, trajectory
from recon.figures.canvas import Sheet
from recon.figures.kinds import Arrays, Kind, Subject
from recon.figures.map3d import Standpoint
from recon.records import Voxels
from recon.voxelmap.ground import height_sum


def _cells(subject: Subject) -> Arrays:
    voxels = subject.mapped.voxels
    kept = ("index", "means", "counts", "colours", "weights")
    values = {name: getattr(voxels, name) for name in kept}
    return {name: value for name, value in values.items() if value is not None}


def _objects(subject: Subject) -> Arrays:
    objects = subject.mapped.objects
    return {
        **_cells(subject),
        "label": np.array([found.label for found in objects], dtype=np.str_),
        # No catalogue: None becomes NaN.
        "probability": np.array([found.probability for found in objects], dtype=np.float64),
        "centre": np.array([found.centre for found in objects]).reshape(-1, 3),
        "size": np.array([found.size for found in objects]).reshape(-1, 3),
    }


def _floor(subject: Subject) -> Arrays:
    grid = height_sum(subject.mapped.voxels)
    return {"cells": grid.cells, "origin_xz": grid.origin_xz}


def _way(subject: Subject) -> Arrays:
    way = subject.mapped.trajectory
    return {"stamps_s": way.stamps_s, "T_world_left": way.T_world_left}


def sigma_cells(voxels: Voxels) -> NDArray[np.float64]:
    """(K,) the sigma, in cells, that corresponds to a cell's mean weight."""
    from recon.voxelmap.weights import Weights

    assert voxels.weights is not None
    mean = np.clip(voxels.weights / voxels.counts, 1e-9, 1.0)
    sigma: NDArray[np.float64] = Weights.SIGMA_OF_HALF * np.sqrt(1.0 / mean - 1.0)
    return sigma


def _no_names(subject: Subject) -> str | None:
    if not parts.largest_of_each(subject.mapped.objects):
        return "no object has a name, so there are no parts to show"
    return None


def _no_weights(subject: Subject) -> str | None:
    if subject.mapped.voxels.weights is None:
        return 'the map keeps no weights; create it with map.occupancy = ["weight"]'
    return None


def _standpoint(subject: Subject) -> Standpoint:
    return Standpoint(view=subject.view, first=subject.first, unit=subject.unit)


def _map3d(subject: Subject, sheet: Sheet) -> Any:
    run = subject.mapped
    return map3d.map3d(run.voxels, run.objects, standpoint=_standpoint(subject), sheet=sheet)


def _solids(subject: Subject, sheet: Sheet) -> Any:
    run = subject.mapped
    return map3d.map3d(
        run.voxels, run.objects, standpoint=_standpoint(subject), with_solids=True, sheet=sheet
    )


def _counts(subject: Subject, sheet: Sheet) -> Any:
    voxels = subject.mapped.voxels
    return map3d.valued(
        voxels,
        voxels.counts.astype(np.float64),
        "points per cell",
        standpoint=_standpoint(subject),
        is_log=True,
        sheet=sheet,
    )


def _sigma(subject: Subject, sheet: Sheet) -> Any:
    voxels = subject.mapped.voxels
    return map3d.valued(
        voxels,
        sigma_cells(voxels),
        "sigma of depth [cells]",
        standpoint=_standpoint(subject),
        sheet=sheet,
    )


def draw_labels(subject: Subject, sheet: Sheet, *, with_legend: bool = True) -> Any:
    """The labelled occupancy of a run."""
    run = subject.mapped
    return occupancy.labels(
        run.voxels, run.objects, trajectory=run.trajectory.T_world_left, states=subject.states,
        unit=subject.unit, with_legend=with_legend, sheet=sheet,
    )  # fmt: skip


def _mesh(subject: Subject, sheet: Sheet) -> Any:
    if subject.mesh is None:
        raise InputError("the run has no mesh.ply, but this kind of figure shows it")
    cameras = np.empty((0, 3)) if subject.cameras is None else subject.cameras
    first = None if subject.run is None else subject.first
    standpoint = Standpoint(view=subject.asked_view, first=first, unit=subject.unit)
    return mesh.mesh(subject.mesh, cameras, standpoint=standpoint, sheet=sheet)


def _mesh_arrays(subject: Subject) -> Arrays:
    assert subject.mesh is not None
    vertices, triangles = subject.mesh.vertices, subject.mesh.triangles
    arrays: dict[str, NDArray[Any]] = {"vertices": vertices, "triangles": triangles}
    colours = subject.mesh.colours
    return arrays if colours is None else {**arrays, "colours": colours}


MESH = Kind(draw=_mesh, data=_mesh_arrays, size=mesh.SIZE, needs_mesh=True, has_view=True)
MAP3D = Kind(draw=_map3d, data=_objects, size=map3d.SIZE, has_view=True)
SOLIDS = Kind(draw=_solids, data=_objects, size=map3d.SIZE, has_view=True)
COUNTS = Kind(draw=_counts, data=_cells, size=map3d.SIZE, has_view=True)
SIGMA = Kind(
    draw=_sigma,
    data=lambda subject: {**_cells(subject), "sigma_cells": sigma_cells(subject.mapped.voxels)},
    size=map3d.SIZE,
    has_view=True,
    lack=_no_weights,
)
PARTS = Kind(
    draw=lambda subject, sheet: parts.parts(
        subject.mapped.voxels, subject.mapped.objects, unit=subject.unit, sheet=sheet
    ),
    data=_objects,
    size=parts.SIZE,
    lack=_no_names,
)
SLICES = Kind(
    draw=lambda subject, sheet: slices.slices(
        subject.mapped.voxels, unit=subject.unit, sheet=sheet
    ),
    data=_cells,
    size=slices.SIZE,
)
OCCUPANCY = Kind(
    draw=lambda subject, sheet: occupancy.occupancy(
        subject.mapped.voxels, unit=subject.unit, sheet=sheet
    ),
    data=_floor,
    size=occupancy.SIZE,
)
LABELS = Kind(draw=draw_labels, data=_objects, size=occupancy.SIZE)
TRAJECTORY = Kind(
    draw=lambda subject, sheet: trajectory.trajectory(
        subject.mapped.trajectory.T_world_left, subject.mapped.voxels, unit=subject.unit,
        sheet=sheet,
    ),
    data=_way,
    size=trajectory.SIZE,
)  # fmt: skip
