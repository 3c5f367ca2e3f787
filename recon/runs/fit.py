"""One solid fitted to one cloud."""

from pathlib import Path
from typing import Any

from recon.errors import ReconError
from recon.exports.formats import read
from recon.exports.partitions.partitioned import PartitionedMap
from recon.notices import collected_notices, notify
from recon.recognition.fitting.outliers import explain
from recon.records import FitFailure, PointCloud, Voxels
from recon.records.solids import parameters
from recon.voxelmap import VoxelMap

LOW_SHARE = 0.9
"""Share of explained points; below, the cloud contains more than the solid."""


def fit_run(path: Path) -> dict[str, Any]:
    """Fit one solid to the points of a cloud, or to the cells of a map.

    Returns
    -------
    dict
        The document of `recon fit --json`.

    Raises
    ------
    ReconError
        If no solid fits, with the reason.
    """
    with collected_notices() as notices:
        found = explain(as_cloud(read(path)).points)
        if isinstance(found, FitFailure):
            raise ReconError(f"{path}: {found.reason}")
        best = found.candidates[0]
        if found.share < LOW_SHARE:
            notify(
                "points-unexplained",
                f"{path}: the {best.solid.kind} explains {found.share:.0%} of the points",
            )
    ranked = [{"shape": one.solid.kind, "rms": one.rms, "bic": one.bic} for one in found.candidates]
    return {
        "shape": best.solid.kind,
        "parameters": parameters(best.solid),
        "rms": found.rms,
        "explained": found.share,
        "candidates": ranked,
        "warnings": [notice.as_json() for notice in notices],
    }


def as_cloud(data: VoxelMap | PartitionedMap | Voxels | PointCloud) -> PointCloud:
    """Points unchanged; for cells, the mean of each."""
    if isinstance(data, PointCloud):
        return data
    voxels = data if isinstance(data, Voxels) else data.occupied(min_count=1)
    return PointCloud(points=voxels.means, colours=voxels.colours)
