"""Jobs, partitioned maps, run folders and meshes for the fuzzer: files that need other files."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from recon.batch.jobfile import read_jobs
from recon.exports import write
from recon.exports.formats import read_mesh
from recon.exports.partitions.manifest import MANIFEST
from recon.exports.partitions.partitioned import PartitionedMap
from recon.exports.partitions.writing import write_partitions
from recon.exports.ply import CloudWriter
from recon.manifest import RunPlan
from recon.records import Mesh, Trajectory
from recon.runfolder import RunFolder
from recon.runs.description import describe
from recon.runs.job import Job
from recon.runs.merge import MERGE
from recon.runs.outputs import cells_hit
from recon.runs.reading import read_reconstruction
from recon.runs.replay import SavedResults
from recon.sequences.calibration.row_error import Residual
from recon.sequences.refined import Refined, read_refined
from recon.settings import Settings
from recon.settings.files import to_toml
from tests.exports.maps import sample_cloud, sample_map

FuzzedFile = tuple[str, Callable[[Path], Any], bytes]

JOBS = """[[job]]
name = "a"
command = "reconstruct"
input = ["left", "right"]
seed = 3
arguments = { chunk = 5 }
settings = { "map.cell_size" = 0.2 }
[sweep]
"map.min_count" = [2, 5]
"""
OBJECTS = {
    "objects": [
        {
            "id": 0, "label": "pine", "probability": 0.9, "centre": [1, 2, 3], "size": [1, 2, 1],
            "num_voxels": 40, "views": 3, "parts": [
                {"role": "body", "shape": "cylinder", "hue_deg": 30.0, "num_voxels": 9, "rms": 0.1,
                 "parameters": {"point": [0, 0, 0], "axis": [0, 1, 0], "radius": 1.0,
                                "height": 2.0}}],
            "reason": None, "nearest": [["pine", 0.9]], "colour": [1, 2, 3], "seen": 0.5,
            "solid": None, "support": None,
            "box": {"centre": [0, 0, 0], "axes": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
                    "sizes": [1, 1, 1], "unit": "m"},
        }
    ],
    "failures": {}, "planes": [],
}  # fmt: skip


def run_files(folder: Path) -> Iterator[FuzzedFile]:
    """Yield (name, reader, content) of each file; the files it needs are written below `folder`."""
    (folder / "left").mkdir(exist_ok=True)
    yield ".jobs.toml", read_jobs, JOBS.encode()
    record = folder / "refined.json"
    Refined(residual=Residual(), poses={"a": np.eye(4)}).write(record)
    yield ".refined.json", read_refined, record.read_bytes()
    yield from _partitions(folder / "map.parquet")
    yield from _run(folder / "run")
    yield from _meshes(folder)


def beside(home: Path, name: str, read: Callable[[Path], Any]) -> Callable[[Path], Any]:
    """Make a reader of a folder that replaces one of its files by the given one."""

    def reader(path: Path) -> Any:
        shutil.copyfile(path, home / name)
        return read(home)

    return reader


def file_in_folder(home: Path, name: str, mark: str, read: Callable[[Path], Any]) -> FuzzedFile:
    """Take one file of a folder, of which a copy is made to keep the others valid."""
    own = home.with_name(f"{home.name}-{mark}")
    shutil.copytree(home, own, dirs_exist_ok=True)
    return f".{mark}", beside(own, name, read), (home / name).read_bytes()


def _partitions(home: Path) -> Iterator[FuzzedFile]:
    city = write_partitions(sample_map(), home, 64)
    for name, mark in ((MANIFEST, "partitions.json"), (city.partitions[0].file, "cells.parquet")):
        yield file_in_folder(home, name, mark, lambda place: PartitionedMap(place).whole())


def _run(home: Path) -> Iterator[FuzzedFile]:
    """Yield the files of a finished run, each with a reader of runs."""
    plan = RunPlan(command="reconstruct", settings_toml=to_toml(Settings()), seed=0, inputs=())
    run = RunFolder.prepare(home, plan, overwrite=True, resume=False)
    with run.opened():
        sample_map(()).save(home / "map.npz")
        run.write_json("objects.json", OBJECTS)
        run.write_json("metrics.json", {"num_pairs": 3, "curve": [[1, 2.0, 0.5]], "warnings": []})
        way = Trajectory(stamps_s=np.arange(3.0), T_world_left=np.array([np.eye(4)] * 3))
        run.write_text("trajectory.txt", way.as_tum())
        with CloudWriter(home / "cloud.ply") as cloud:
            cloud.append(sample_cloud(num=20), 0)
    for name in ("manifest.json", "settings.toml", "objects.json", "trajectory.txt", "map.npz"):
        yield file_in_folder(home, name, f"run-{name}", read_reconstruction)
    for name in ("manifest.json", "metrics.json"):
        yield file_in_folder(home, name, f"info-{name}", describe)
    yield file_in_folder(home, "cloud.ply", "run-cloud.ply", _cells_of_run)
    yield file_in_folder(home, "manifest.json", "merged-manifest.json", _merged)
    yield _partial(home.parent)


def _cells_of_run(run: Path) -> Any:
    return list(cells_hit(run / "cloud.ply", 0.5))


def _merged(run: Path) -> Any:
    return MERGE.base(Job(kind="merge", inputs=(run,)))


def _partial(folder: Path) -> FuzzedFile:
    """Take the matches of a pair that an interrupted run saved."""
    from recon.mapping.pair import PairResult
    from recon.records import Matches

    numbers = np.arange(5.0)
    matches = Matches(
        points_px=np.column_stack([numbers, numbers]), disparity_px=numbers, sigma_px=numbers + 1,
        score=np.ones(5), index_left=np.arange(5), index_right=np.arange(5),
    )  # fmt: skip
    cloud = sample_cloud(num=5)
    result = PairResult(matches=matches, cloud=cloud, doubtful=cloud, image_noise=(1.0, 1.0))
    home = folder / "partial"
    home.mkdir(exist_ok=True)
    saved = SavedResults(folder=home)
    saved.keep(0, result)
    return file_in_folder(
        home, saved.path(0).name, "partial.npz", lambda one: SavedResults(folder=one).load(0)
    )


def _meshes(folder: Path) -> Iterator[FuzzedFile]:
    mesh = Mesh(
        vertices=np.eye(4, 3),
        triangles=np.array([[0, 1, 2], [1, 2, 3]], np.int32),
        colours=np.full((4, 3), 9, np.uint8),
    )
    for ending in (".ply", ".obj", ".stl", ".off", ".glb"):
        write(mesh, folder / f"mesh{ending}")
        yield f".mesh{ending}", read_mesh, (folder / f"mesh{ending}").read_bytes()
