"""Evaluation of a run's trajectory against the true one."""

from dataclasses import asdict
from pathlib import Path

from recon.runs.arguments import path
from recon.runs.job import Job, Kind, Numbers
from recon.runs.work import Work
from recon.sequences.odometry.errors import paired_poses, trajectory_errors
from recon.sequences.pose_files import read_poses


def _evaluate(job: Job, work: Work) -> Numbers:
    """Absolute and relative errors of a run's trajectory, or of a file of poses."""
    del work
    (path,) = job.inputs
    estimated = read_poses(_trajectory(path))
    return asdict(trajectory_errors(*paired_poses(estimated, read_poses(job.arguments["truth"]))))


def _trajectory(path: Path) -> Path:
    """The file of a run folder, or a file itself."""
    return path / "trajectory.txt" if path.is_dir() else path


TRAJECTORY = Kind(run=_evaluate, takes={"truth": path})
