"""Evaluation of a surface against the true one."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.exports.formats import holds_mesh, read, read_mesh
from recon.exports.triangles import sampled
from recon.geometry import Array
from recon.records import PointCloud
from recon.runs.arguments import path, positives
from recon.runs.job import Job, Kind, Numbers
from recon.runs.report import read_json
from recon.runs.work import Work
from recon.surface.evaluation import Judged, judge

NUM_SAMPLES = 200_000
_VOXELS = (0.5, 1.0, 2.5)
_SIZE_SHARES = (0.002, 0.005, 0.01)
"""Distances relative to the truth's diagonal, if the run has no voxels."""


def _judge(job: Job, work: Work) -> Numbers:
    """Accuracy, completeness and F-score of a run's surface."""
    run, truth_path = job.arguments["surface"], job.arguments["truth"]
    with work.stage("reading"):
        found = _read(_surface_file(run), job.seed)
        truth = _truth(truth_path, job.seed)
    distances = job.arguments.get("distances") or _distances(run, truth.points)
    with work.stage("surface"):
        return judge(found, truth, distances).as_metrics()


def _surface_file(run: Path) -> Path:
    """The mesh of a run, else its dense cloud; or a given file."""
    if run.is_file():
        return run
    for name in ("mesh.ply", "dense.ply"):
        if (run / name).is_file():
            return run / name
    raise InputError(f"{run} has neither mesh.ply nor dense.ply: reconstruct with --mesh")


def _truth(path: Path, seed: int) -> Judged:
    """The true surface: a mesh, a cloud, or the output of `recon render`."""
    if not path.is_dir():
        return _read(path, seed)
    if not (path / "scene.ply").is_file() or not (path / "seen.ply").is_file():
        raise InputError(f"{path} has no scene.ply and seen.ply, as written by recon render")
    seen = _read(path / "seen.ply", seed)
    return Judged(points=seen.points, mesh=read_mesh(path / "scene.ply"))


def _read(path: Path, seed: int) -> Judged:
    if holds_mesh(path):
        mesh = read_mesh(path)
        points = sampled(mesh, NUM_SAMPLES, np.random.default_rng(seed)).points
        return Judged(points=points, mesh=mesh)
    data = read(path)
    if not isinstance(data, PointCloud) or not len(data):
        raise InputError(f"{path} contains neither triangles nor points, but a surface is needed")
    return Judged(points=data.points)


def _distances(run: Path, truth: Array) -> Sequence[float]:
    metrics = run / "metrics.json"
    voxel = read_json(metrics).get("voxel") if metrics.is_file() else None
    if voxel:
        return [float(f"{share * voxel:g}") for share in _VOXELS]
    size = float(np.linalg.norm(np.ptp(truth, axis=0)))
    return [float(f"{share * size:.2g}") for share in _SIZE_SHARES]


SURFACE = Kind(
    run=_judge,
    num_inputs=0,
    takes={"surface": path, "truth": path, "distances": positives},
    stages=("reading", "surface"),
)
"""`recon evaluate --surface`."""
