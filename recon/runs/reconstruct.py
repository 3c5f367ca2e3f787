"""A reconstruction, from a recording to a run folder."""

import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from recon.exports.ply import CloudWriter
from recon.geometry import transform
from recon.mapping.pair import match_images
from recon.recognition import recognise
from recon.records import StereoPair
from recon.runfolder import RunFolder
from recon.runs.contents import RunContents
from recon.runs.figures import leave_figures
from recon.runs.order import Progress, RunOrder
from recon.runs.products import with_views, write_metrics, write_products
from recon.runs.report import read_report
from recon.runs.tally import Tally
from recon.sequences.frames import DerivedSource
from recon.sequences.open import open_sequence
from recon.sequences.readers.ring import is_ring
from recon.sequences.truth import read_truth
from recon.settings import Settings, updated, with_quality
from recon.voxelmap.occupancy import occupied

# At middle depth a cell is so many times as long as the uncertainty of a well-matched point, and as
# wide as so many pixels, which is about twice as far apart as features are.
SIGMAS_TO_CELL = 2.0
SIGMA_PX = 0.15
PIXELS_TO_CELL = 6.0

# Searched where a recording does not say what occurs in it.
DISPARITY_RANGE = (0, 127)


def base_values(path: Path, format_: str = "auto") -> dict[str, Any]:
    """Settings that a recording itself suggests, by "stage.name".

    Its search range, and a cell size that goes with the depths it can see.
    """
    chosen = updated(Settings(), {"sequence": {"format": format_}})
    source = open_sequence(path, chosen.sequence)
    low, high = source.disparity_range or DISPARITY_RANGE
    search = {"min_disparity": low, "max_disparity": high}
    values: dict[str, Any] = {f"matching.{name}": value for name, value in search.items()}
    pair = next(iter(source))
    values["map.cell_size"] = suggested_cell_size(pair, updated(chosen, {"matching": search}))
    values |= {"map.min_count": min(2, len(source)), "recognition.ground": "none"}
    if len(source) > 1:
        # What moves, and what was matched wrongly, is seen once.
        values["map.occupancy"] = ["count", "views"]
    if is_ring(path):
        values["sequence.only_confirmed"] = True
    return values


def suggested_cell_size(pair: StereoPair, settings: Settings) -> float:
    """Side of a cell that suits what a pair sees; 1 where it sees nothing."""
    matches = match_images(pair.left, pair.right, with_quality(settings, "fast"))
    depth = pair.rig.depth(matches.disparity_px)
    depth = depth[np.isfinite(depth)]
    if not len(depth):
        return 1.0
    middle = float(np.median(depth))
    deep = SIGMAS_TO_CELL * float(pair.rig.depth_sigma(middle, SIGMA_PX))
    return rounded(max(deep, PIXELS_TO_CELL * middle / pair.rig.focal_px))


def rounded(length: float) -> float:
    """The nearest of ... 0.1, 0.2, 0.5, 1, 2, 5 ..., by ratio."""
    steps = [digit * 10.0**power for power in range(-6, 7) for digit in (1, 2, 5)]
    return float(f"{min(steps, key=lambda step: abs(np.log(step / length))):g}")


def reconstruct_run(path: Path, settings: Settings, order: RunOrder) -> dict[str, Any]:
    """Rebuild what a recording saw and leave its run folder.

    Returns
    -------
    dict
        The document of `recon reconstruct --json`: metrics.json with `run` and `objects`.
    """
    source = open_sequence(path, settings.sequence)
    run = order.folder("reconstruct", settings, (path,))
    if not run.is_finished:
        with run.opened():
            _reconstruct_into(run, path, source, settings, order.progress)
    return read_report(run.path)


def _reconstruct_into(
    run: RunFolder, path: Path, source: DerivedSource, settings: Settings, progress: Progress
) -> None:
    began = time.perf_counter()
    tally = Tally(settings)
    with CloudWriter(run.path / "cloud.ply") as writer:
        for pair in source:
            for seen in tally.take(pair):
                writer.append(seen.cloud, seen.number)
            progress(tally.num_pairs, len(source))
        for seen in tally.finish():
            writer.append(seen.cloud, seen.number)
    run.seconds |= {"stereo": tally.stereo_s, "map": tally.map_s}
    _write(run, tally, settings)
    metrics = tally.metrics | {"num_skipped": len(source.skipped)} | _surface_distance(path, tally)
    metrics |= source.metrics
    run.seconds["total"] = time.perf_counter() - began
    write_metrics(run, metrics | {"seconds": run.seconds})


def _write(run: RunFolder, tally: Tally, settings: Settings) -> None:
    voxels = occupied(tally.voxel_map, settings.map)
    tally.num_voxels = len(voxels)
    recognition = with_views(
        recognise(voxels, settings.recognition), voxels, run.path / "cloud.ply"
    )
    write_products(run, tally.voxel_map, recognition, tally.trajectory)
    contents = RunContents(voxels=voxels, objects=recognition.objects, trajectory=tally.trajectory)
    clearest = tally.clearest
    seen = None if clearest is None else (clearest.pair.left, clearest.matches)
    leave_figures(run.path, contents, seen)


def _surface_distance(path: Path, tally: Tally) -> dict[str, float]:
    """Median distance of the points to the true surface, where a pair comes with its truth."""
    seen = tally.clearest
    if seen is None or tally.num_pairs > 1 or not list(path.glob("disp_left.*")):
        return {}
    truth = read_truth(path)
    v, u = np.nonzero(np.isfinite(truth.disparity_px))
    surface = seen.pair.rig.triangulate(np.column_stack([u, v]), truth.disparity_px[v, u])
    if seen.pair.T_world_left is not None:
        surface = transform(seen.pair.T_world_left, surface)
    distance, _ = cKDTree(surface).query(seen.cloud.points)
    return {"surface_distance_median": float(np.median(distance))}
