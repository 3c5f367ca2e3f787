"""Merging of runs of one world: their maps are added, as if from one recording."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import accumulate
from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.exports.partitions.partitioned import PartitionedMap
from recon.exports.partitions.writing import merge_partitions, write_partitions
from recon.exports.ply import CloudWriter, read_cloud_chunks
from recon.manifest import is_finished, read_manifest
from recon.mapping.views import with_views
from recon.recognition.recognition import recognise
from recon.records import Reconstruction, Trajectory
from recon.runs.arguments import check_distinct
from recon.runs.cameras import CAMERAS, cameras_text, read_cameras
from recon.runs.figures import draw_run_figures
from recon.runs.job import Job, Kind, Numbers, Tree
from recon.runs.maps import PARTITIONED, read_map, shown
from recon.runs.outputs import cells_hit, write_outputs
from recon.runs.reading import read_settings, read_trajectory
from recon.runs.surfaces import merge_surfaces
from recon.runs.work import Work
from recon.settings import Settings

KEPT = ("map", "recognition", "sequence", "matching", "surface")
"""Settings that the merged run takes from the first run."""
MATTERING = ("cell_size", "occupancy", "partition_size", "ray_margin")
"""Settings of the map that have to match."""


def _base(job: Job) -> Tree:
    """The settings of the first run, which those of the others have to match."""
    check_distinct(job.inputs)
    found = [_settings(run) for run in job.inputs]
    for run, settings in zip(job.inputs, found, strict=True):
        for name in MATTERING:
            own, first = getattr(settings.map, name), getattr(found[0].map, name)
            if own != first:
                raise InputError(
                    f"{run} has map.{name} = {own}, but {first} is needed, as in {job.inputs[0]}"
                )
    first_settings = asdict(found[0])
    return {stage: first_settings[stage] for stage in KEPT}


def _settings(run: Path) -> Settings:
    if not is_finished(run):
        raise InputError(f"{run} is not a finished run, but its map is needed")
    return read_settings(run)


def _merge(job: Job, work: Work) -> Numbers:
    """Add the maps of runs and write a merged run folder."""
    ways = [read_trajectory(run) for run in job.inputs]
    first_views = _first_views(job.inputs, ways)
    with work.stage("map"):
        parts = list(_partitioned(job, work))
        whole = merge_partitions(parts, work.run.path / PARTITIONED, first_views)
    with work.stage("write"):
        num_points = _write_cloud(job, work, first_views)
    _write_cameras(job, work)
    voxels, shown_map = shown(whole, job.settings.map)
    way = _joined(ways)
    with work.stage("recognise"):
        found = recognise(voxels, job.settings.recognition, way.T_world_left)
        found = with_views(found, voxels, cells_hit(work.run.path / "cloud.ply", voxels.cell_size))
    all_of_it = Reconstruction(map=shown_map, voxels=voxels, objects=found.objects, trajectory=way)
    with work.stage("write"):
        write_outputs(work.run, all_of_it, found)
    with work.stage("figures"):
        draw_run_figures(work, all_of_it, None)
        work.artist.finish()
    surfaces = merge_surfaces(job.inputs, job.settings, way, work)
    return surfaces | {
        "num_runs": len(job.inputs),
        "num_pairs": len(way),
        "num_points": num_points,
        "num_voxels": len(voxels),
        "num_partitions": len(whole),
    }


def _first_views(runs: Sequence[Path], ways: list[Trajectory]) -> list[int]:
    """Offsets of the pair numbers of each run; the numbers of a part start at its first pair."""
    before = [0, *accumulate(map(len, ways))]
    starts = [(read_manifest(run).get("arguments") or {}).get("part", [0])[0] for run in runs]
    return [number - start for number, start in zip(before, starts, strict=False)]


def _partitioned(job: Job, work: Work) -> Iterator[PartitionedMap]:
    """The partitioned map of every run; single-file maps are partitioned."""
    for number, run in enumerate(job.inputs):
        found = read_map(run)
        if not isinstance(found, PartitionedMap):
            place = work.run.partial / f"{number:06d}.parquet"
            found = write_partitions(found, place, job.settings.map.partition_size)
        yield found
        work.progress(number + 1, len(job.inputs))


def _write_cloud(job: Job, work: Work, first_views: list[int]) -> int:
    """Write the points of all runs with consecutive pair numbers; return their number."""
    num = 0
    with CloudWriter(work.run.path / "cloud.ply") as cloud:
        for run, first in zip(job.inputs, first_views, strict=True):
            for points, numbers in read_cloud_chunks(run / "cloud.ply"):
                cloud.append(points, numbers + first)
                num += len(points)
    return num


def _write_cameras(job: Job, work: Work) -> None:
    """Write the cameras of all pairs, if every run has them."""
    files = [run / CAMERAS for run in job.inputs]
    if all(file.is_file() for file in files):
        seen = [one for file in files for one in read_cameras(file)]
        work.run.write_text(CAMERAS, cameras_text(seen))


def _joined(ways: list[Trajectory]) -> Trajectory:
    return Trajectory(
        stamps_s=np.concatenate([way.stamps_s for way in ways]),
        T_world_left=np.concatenate([way.T_world_left for way in ways]),
    )


MERGE = Kind(
    run=_merge,
    num_inputs=None,
    base=_base,
    folder=lambda job: Path("runs") / "merged",
    stages=("map", "recognise", "figures", "write"),
)
