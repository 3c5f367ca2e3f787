"""Absolute and relative errors of a trajectory, as defined by evo."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.geometry import invert
from recon.sequences.poses import GivenPoses
from recon.sequences.units import matched

Array = NDArray[np.float64]

MIN_POSES = 3
"""Fewer are uninformative."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryErrors:
    """Errors of a trajectory; lengths in world units."""

    num_poses: int
    length: float
    """Length of the true path."""
    ate_rmse: float
    """Root mean square distance of positions after rigid alignment (Umeyama, no scale)."""
    rpe_rmse: float
    """Root mean square error of the translation from each pose to the next."""
    rpe_rotation_rmse_deg: float
    """Root mean square error of the rotation from each pose to the next."""
    drift_percent: float
    """`ate_rmse` in percent of the length."""


def trajectory_errors(estimated: ArrayLike, true: ArrayLike) -> TrajectoryErrors:
    """Errors of estimated poses.

    Parameters
    ----------
    estimated, true : (N, 4, 4) array_like
        Poses of the same frames, each in its own world.

    Raises
    ------
    InputError
        If there are fewer than three poses, or the true path has no length.
    """
    found, wanted = (np.asarray(poses, dtype=np.float64) for poses in (estimated, true))
    if len(wanted) < MIN_POSES:
        raise InputError(f"{len(wanted)} poses have a true one, but {MIN_POSES} are needed")
    length = _length(wanted[:, :3, 3])
    ate = _rms(np.linalg.norm(aligned(found[:, :3, 3], wanted[:, :3, 3]), axis=1))
    steps = [
        invert(invert(wanted[n]) @ wanted[n + 1]) @ invert(found[n]) @ found[n + 1]
        for n in range(len(wanted) - 1)
    ]
    turns = Rotation.from_matrix(np.array(steps)[:, :3, :3]).magnitude()
    return TrajectoryErrors(
        num_poses=len(wanted),
        length=length,
        ate_rmse=ate,
        rpe_rmse=_rms(np.linalg.norm(np.array(steps)[:, :3, 3], axis=1)),
        rpe_rotation_rmse_deg=float(np.degrees(_rms(turns))),
        drift_percent=100.0 * ate / length,
    )


def drift_percent(estimated: ArrayLike, true: ArrayLike) -> float:
    """Root mean square distance of rigidly aligned positions, percent of the true path's length.

    Parameters
    ----------
    estimated, true : (N, 4, 4) array_like
        Poses of the same frames, each in its own world.

    Raises
    ------
    InputError
        If the true path has no length.
    """
    path, reference = (np.asarray(poses, dtype=np.float64)[:, :3, 3] for poses in (estimated, true))
    length = _length(reference)
    return 100.0 * _rms(np.linalg.norm(aligned(path, reference), axis=1)) / length


def _length(path: Array) -> float:
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    if not length > 0:
        raise InputError("the true path has no length, but drift is a share of it")
    return length


def aligned(path: Array, reference: Array) -> Array:
    """(N, 3) offsets of positions from the reference after rigid alignment."""
    path, reference = path - path.mean(axis=0), reference - reference.mean(axis=0)
    # Kabsch's rotation; unlike evo's it also aligns a straight path, whose roll is undetermined.
    u, _, vt = np.linalg.svd(reference.T @ path)
    offsets: Array = path @ (u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt).T - reference
    return offsets


def paired_poses(estimated: GivenPoses, true: GivenPoses) -> tuple[Array, Array]:
    """The poses (N, 4, 4) of both for their common frames: by time, else by row.

    Raises
    ------
    InputError
        If times do not overlap, or the numbers of rows without times differ.
    """
    if true.stamps_s is None or estimated.stamps_s is None:
        if len(true) != len(estimated):
            raise InputError(
                f"there are {len(true)} true poses without times for {len(estimated)} estimated "
                "ones, but equally many are needed"
            )
        return estimated.poses, true.poses
    stamps = matched(estimated.stamps_s, true.stamps_s, "the estimated poses")
    wanted = [true.at(float(stamp)) for stamp in stamps]
    both = [(f, w) for f, w in zip(estimated.poses, wanted, strict=True) if w is not None]
    if not both:
        raise InputError("no estimated pose has a true one near its time")
    found, known = np.array(both).swapaxes(0, 1)
    return found, known


def _rms(errors: ArrayLike) -> float:
    return float(np.sqrt(np.mean(np.square(errors))))
