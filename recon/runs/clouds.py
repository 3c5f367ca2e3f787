"""Maps and clouds from files: named, fitted, written in other formats."""

from pathlib import Path
from typing import Any

from recon.errors import InputError, ReconError
from recon.exports.formats import format_of, read, write
from recon.recognition import recognise
from recon.recognition.clouds import Up, recognise_cloud
from recon.recognition.fitting.shapes import candidates
from recon.records import FitFailure, PointCloud, Voxels
from recon.records.objects import as_json
from recon.records.solids import parameters
from recon.runs.job import Job, Kind, Numbers
from recon.runs.work import Work
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import occupied

Box = tuple[tuple[float, ...], tuple[float, ...]]


def _recognise(job: Job, work: Work) -> Numbers:
    """Name the objects of a map or a cloud; the document of `objects.json`."""
    (path,) = job.inputs
    up: Up = job.arguments.get("up", "y")
    data = read(path)
    if isinstance(data, VoxelMap):
        data = occupied(data, job.settings.map)
    with work.stage("recognise"):
        if isinstance(data, Voxels) and up == "y":
            return dict(as_json(recognise(data, job.settings.recognition)))
        return dict(as_json(recognise_cloud(_as_cloud(data), job.settings.recognition, up)))


def fit_run(path: Path) -> dict[str, Any]:
    """Fit one solid to the points of a cloud, or to the cells of a map.

    Returns
    -------
    dict
        The document of `recon fit --json`.

    Raises
    ------
    ReconError
        Where no solid fits, with the reason.
    """
    found = candidates(_as_cloud(read(path)).points)
    if isinstance(found, FitFailure):
        raise ReconError(f"{path}: {found.reason}")
    ranked = [{"shape": one.solid.kind, "rms": one.rms, "bic": one.bic} for one in found]
    best = found[0]
    return {
        "shape": best.solid.kind,
        "parameters": parameters(best.solid),
        "rms": best.rms,
        "candidates": ranked,
    }


def export_run(
    source: Path, target: Path, *, box: Box | None = None, overwrite: bool = False
) -> dict[str, Any]:
    """Write what `source` holds in the format that the ending of `target` names.

    Returns
    -------
    dict
        The document of `recon export --json`.
    """
    written = [target.with_suffix(s) for s in (".pgm", ".yaml")] if is_nav2(target) else [target]
    for path in written:
        if path.exists() and not overwrite:
            raise InputError(f"{path} exists; give --overwrite or another name")
    write(read(source), target, box=box)
    files = [path for path in target.rglob("*") if path.is_file()] or written
    return {
        "output": str(target),
        "up": format_of(target).up,
        "bytes": sum(path.stat().st_size for path in files),
    }


def is_nav2(path: Path) -> bool:
    """Whether an image and its description are written together."""
    return path.suffix.lower() in (".pgm", ".yaml")


def _as_cloud(data: VoxelMap | Voxels | PointCloud) -> PointCloud:
    """Points as they are; of cells, the mean of each."""
    if isinstance(data, PointCloud):
        return data
    voxels = data.occupied(min_count=1) if isinstance(data, VoxelMap) else data
    return PointCloud(points=voxels.means, colours=voxels.colours)


RECOGNISE = Kind(run=_recognise)
