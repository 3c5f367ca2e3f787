"""Errors of the poses of places, as places that show the same reveal them.

Recorded poses have errors of their own, which differ from recording to recording; those of a
simulator have none.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.camera import StereoRig
from recon.geometry import invert
from recon.localisation.atlas import Atlas
from recon.localisation.candidates import COVERED_COSINE, COVERED_SHARE
from recon.localisation.precision import information, shares, supported
from recon.records import PoseEstimate
from recon.sequences.odometry.motion import Linearised, linearise
from recon.sequences.odometry.places import Meeting, meet
from recon.sequences.odometry.tracking import Tracks

Array = NDArray[np.float64]

NUM_PLACES = 24
"""Maximum number of places that are compared with the next one."""
MIN_AGREEING = 24
"""Minimum number of agreeing points of two places."""
OWN_PX = 0.05
"""Standard deviation of the error of a blob's disparity that is the same in both places, against
the truth of rendered worlds."""
LEAST_CELLS, LEAST_DEG = 0.01, 0.01
"""Least standard deviations of a place's position, in cells, and rotation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceErrors:
    """Standard deviations of the pose of a place along and about each axis."""

    turn: float
    """Radians."""
    shift: float
    """World units."""

    @classmethod
    def of(cls, atlas: Atlas, cell_size: float) -> "PlaceErrors":
        """The errors that the motions between neighbouring places have beyond those of points."""
        rows = np.unique(np.linspace(0, max(len(atlas) - 2, 0), NUM_PLACES).astype(np.intp))
        found = [_compared(atlas, int(row)) for row in rows if row + 1 < len(atlas)]
        off, expected = (
            np.array([one[part] for one in found if one is not None]).reshape(-1, 2, 3)
            for part in (0, 1)
        )
        turn, shift = (_beyond(off[:, part], expected[:, part]) for part in (0, 1))
        return cls(
            turn=float(np.hypot(turn, np.radians(LEAST_DEG))),
            shift=float(np.hypot(shift, LEAST_CELLS * cell_size)),
        )

    @property
    def covariance(self) -> Array:
        """(6, 6), in the order of `PoseEstimate`."""
        return np.diag(np.repeat([self.turn, self.shift], 3) ** 2)


def motion_covariance(met: Meeting, rig: StereoRig) -> Array:
    """Covariance (6, 6) of the motion between two places, from their common points."""
    at = linearise(met.T_second_first, met.tracks, rig)
    share = shares(met.tracks)
    known = information(at.residual, supported(at.residual, at.by_motion, share), share)
    feigned = _feigned(at, met, rig)
    return np.asarray(np.linalg.pinv(known) + np.outer(feigned, feigned), np.float64)


def _feigned(at: Linearised, met: Meeting, rig: StereoRig) -> Array:
    """Error (6,) of a motion that the points' own errors of depth make likely.

    They are the same in both places and leave no residual, but points that seem to be at several
    distances and yet move alike feign that the camera moved less and turned instead. To second
    order: the mean product of what such an error changes in the residual and in its derivative.
    """
    nearer, farther = (
        linearise(met.T_second_first, _changed(met.tracks, px), rig) for px in (OWN_PX, -OWN_PX)
    )
    residual = (nearer.residual - farther.residual) / 2.0
    derivative = (nearer.by_motion - farther.by_motion) / 2.0
    pull = np.einsum("n,nij,ni->j", at.weights, derivative, residual)
    error: Array = np.linalg.pinv(at.normal_equations()[0]) @ pull
    return error


def _changed(tracks: Tracks, by_px: float) -> Tracks:
    """The tracks with all disparities of both pairs changed."""
    first, second = (
        replace(one, disparity_px=one.disparity_px + by_px) for one in (tracks.first, tracks.second)
    )
    return Tracks(first=first, second=second)


def measured_from(T_world_first: Array, met: Meeting, rig: StereoRig, own: Array) -> PoseEstimate:
    """The pose of a pair from a known one, with the uncertainty of the points and of that pose.

    Parameters
    ----------
    T_world_first : (4, 4) array
    met : Meeting
        Of the known pair with this one.
    rig : StereoRig
        Of this pair.
    own : (6, 6) array
        Covariance of the known pose.
    """
    T_world_left = T_world_first @ invert(met.T_second_first)
    turn = np.kron(np.eye(2), T_world_left[:3, :3])
    return PoseEstimate(
        T_world_left=T_world_left,
        covariance=turn @ motion_covariance(met, rig) @ turn.T + own,
        probability=0.0,
        residual=1.0,
        inlier_share=met.share,
        num_cells=0,
    )


def _compared(atlas: Atlas, row: int) -> tuple[Array, Array] | None:
    """Rotation and shift (6,) between a place and the next beyond their poses, and variances."""
    first, second = atlas.places[row : row + 2]
    T_first, T_second = atlas.T_world_left[row : row + 2]
    apart = np.linalg.norm(T_second[:3, 3] - T_first[:3, 3])
    if apart > COVERED_SHARE * second.depth or T_first[:3, 2] @ T_second[:3, 2] < COVERED_COSINE:
        return None  # these show other things; if they look alike, no pose is wrong
    met = meet(first, second)
    if met is None or met.num_agreeing < MIN_AGREEING:
        return None
    off = met.T_second_first @ invert(T_first) @ T_second
    both = np.concatenate([Rotation.from_matrix(off[:3, :3]).as_rotvec(), off[:3, 3]])
    return both, np.diag(motion_covariance(met, second.rig))


def _beyond(off: Array, expected: Array) -> float:
    """Standard deviation of each end that explains errors beyond the expected variances."""
    if not off.size:
        return 0.0
    # The mean, not the median: a recording with some poses that are wrong is less certain.
    excess = float(np.mean(off**2) - np.mean(expected))
    return float(np.sqrt(max(excess, 0.0) / 2.0))
