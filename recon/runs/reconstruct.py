"""A reconstruction, from a recording to a run folder."""

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.exports.ply import CloudWriter
from recon.geometry import transform
from recon.pipeline import PairResult, process_sequence
from recon.recognition import recognise
from recon.records import PairSource, StereoPair
from recon.runfolder import RunFolder, RunPlan
from recon.runs.contents import RunContents, Trajectory
from recon.runs.figures import add_pair, draw_always, write_figures
from recon.runs.products import Progress, with_views, write_metrics, write_products
from recon.runs.report import read_report
from recon.sequences.open import open_sequence
from recon.sequences.truth import read_truth
from recon.settings import Settings, to_toml, updated
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import new_map, occupied

# Of the smallest depth that the search range reaches: fine enough to show the shape of things,
# coarse enough that several points meet in a cell.
CELLS_TO_NEAREST = 80

# Searched where a recording does not say what occurs in it.
DISPARITY_RANGE = (0, 127)


def base_values(path: Path, format_: str = "auto") -> dict[str, Any]:
    """Settings that a recording itself suggests, by "stage.name".

    Its search range, and a cell size that goes with the depths it can see.
    """
    chosen = updated(Settings(), {"sequence": {"format": format_}})
    source = open_sequence(path, chosen.sequence)
    low, high = source.disparity_range or DISPARITY_RANGE
    nearest = float(next(iter(source)).rig.depth(high))
    return {
        "matching.min_disparity": low,
        "matching.max_disparity": high,
        "map.cell_size": rounded(nearest / CELLS_TO_NEAREST),
        "map.min_count": 2,
        "recognition.ground": "none",
    }


def rounded(length: float) -> float:
    """The nearest of ... 0.1, 0.2, 0.5, 1, 2, 5 ..., by ratio."""
    steps = [digit * 10.0**power for power in range(-6, 7) for digit in (1, 2, 5)]
    return float(f"{min(steps, key=lambda step: abs(np.log(step / length))):g}")


def reconstruct_run(
    path: Path,
    run_path: Path,
    settings: Settings,
    *,
    seed: int = 0,
    overwrite: bool = False,
    resume: bool = False,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Rebuild what a recording saw and leave its run folder.

    Returns
    -------
    dict
        The document of `recon reconstruct --json`: metrics.json with `run` and `objects`.
    """
    source = open_sequence(path, settings.sequence)
    plan = RunPlan(
        command="reconstruct", settings_toml=to_toml(settings), seed=seed, inputs=(path,)
    )
    run = RunFolder.prepare(run_path, plan, overwrite=overwrite, resume=resume)
    if not run.is_finished:
        with run.opened():
            _reconstruct_into(run, path, source, settings, progress)
    return read_report(run.path)


def _reconstruct_into(
    run: RunFolder, path: Path, source: PairSource, settings: Settings, progress: Progress | None
) -> None:
    began = time.perf_counter()
    tally = Tally(voxel_map=new_map(settings.map))
    with CloudWriter(run.path / "cloud.ply") as writer:
        for pair, result in process_sequence(source, settings, tally.voxel_map):
            writer.append(result.cloud, tally.num_pairs)
            tally.add(pair, result)
            if progress is not None:
                progress(tally.num_pairs, len(source))
    run.seconds |= {"stereo": tally.stereo_s, "map": tally.map_s}
    _write(run, tally, settings)
    truth = _surface_distance(path, tally) if tally.num_pairs == 1 else {}
    run.seconds["total"] = time.perf_counter() - began
    write_metrics(run, tally.metrics(len(source.skipped)) | truth | {"seconds": run.seconds})


@dataclass(slots=True, kw_only=True, eq=False)
class Tally:
    """What has come of the pairs so far; as large as the map and the trajectory."""

    voxel_map: VoxelMap
    stamps_s: list[float] = field(default_factory=list)
    T_world_left: list[NDArray[np.float64]] = field(default_factory=list)
    clearest: tuple[StereoPair, PairResult] | None = None
    num_points: int = 0
    num_voxels: int = 0
    stereo_s: float = 0.0
    map_s: float = 0.0

    @property
    def num_pairs(self) -> int:
        """Pairs read so far."""
        return len(self.stamps_s)

    def add(self, pair: StereoPair, result: PairResult) -> None:
        """Count one pair."""
        self.stamps_s.append(pair.stamp_s)
        self.T_world_left.append(np.eye(4) if pair.T_world_left is None else pair.T_world_left)
        self.num_points += len(result.cloud)
        self.stereo_s += result.stereo_s
        self.map_s += result.map_s
        if self.clearest is None or len(result.matches) > len(self.clearest[1].matches):
            self.clearest = pair, result

    def metrics(self, num_skipped: int) -> dict[str, Any]:
        """The numbers of `metrics.json` that need no truth."""
        return {
            "num_pairs": self.num_pairs,
            "num_skipped": num_skipped,
            "num_points": self.num_points,
            "num_voxels": self.num_voxels,
        }


def _write(run: RunFolder, tally: Tally, settings: Settings) -> None:
    voxels = occupied(tally.voxel_map, settings.map)
    tally.num_voxels = len(voxels)
    recognition = with_views(
        recognise(voxels, settings.recognition), voxels, run.path / "cloud.ply"
    )
    trajectory = Trajectory(
        stamps_s=np.array(tally.stamps_s), T_world_left=np.array(tally.T_world_left)
    )
    write_products(run, tally.voxel_map, recognition, trajectory)
    contents = RunContents(voxels=voxels, objects=recognition.objects, trajectory=trajectory)
    pictures = draw_always(contents)
    if tally.clearest is not None:
        pair, result = tally.clearest
        pictures = add_pair(pictures, pair.left, result.matches)
    write_figures(run.path, pictures)


def _surface_distance(path: Path, tally: Tally) -> dict[str, float]:
    """Median distance of the points to the true surface, where the pair comes with its truth."""
    if tally.clearest is None or not list(path.glob("disp_left.*")):
        return {}
    pair, result = tally.clearest
    truth = read_truth(path)
    v, u = np.nonzero(np.isfinite(truth.disparity_px))
    surface = pair.rig.triangulate(np.column_stack([u, v]), truth.disparity_px[v, u])
    pose = np.eye(4) if pair.T_world_left is None else pair.T_world_left
    distance, _ = cKDTree(transform(pose, surface)).query(result.cloud.points)
    return {"surface_distance_median": float(np.median(distance))}
