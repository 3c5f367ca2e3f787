"""Motions of the rig that the images show."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.geometry import transform
from recon.records import StereoPair
from recon.sequences.odometry.motion import agreeing_tracks, refine_motion
from recon.sequences.odometry.tracking import NUM_CORNERS, Tracks, track

Array = NDArray[np.float64]

MIN_FLOW_PX = 2.0
"""Median displacement of points in the image below which a rig is at rest."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step:
    """Two pairs of one rig, and the motion between them that the images show."""

    first: StereoPair
    second: StereoPair
    tracks: Tracks
    """Points that agree on the motion."""
    all_tracks: Tracks
    T_second_first: Array
    """(4, 4) of the left camera."""
    num_corners: int = NUM_CORNERS
    """Approximate number of corners that were to be tracked."""

    def error_px(self, T_second_first: Array) -> float:
        """Median reprojection error of the points in the second left image under a motion."""
        rig = self.first.rig
        points = rig.triangulate(self.tracks.first.points_px, self.tracks.first.disparity_px)
        moved = transform(T_second_first, points)
        ahead = moved[:, 2] > 1e-6
        if not ahead.any():
            return float("inf")
        error = rig.project_left(moved[ahead]) - self.tracks.second.points_px[ahead]
        return float(np.median(np.linalg.norm(error, axis=1)))

    @property
    def name(self) -> str:
        """Name of the second pair."""
        return self.second.name

    @property
    def is_posed(self) -> bool:
        """True if both pairs have poses."""
        return self.first.T_world_left is not None and self.second.T_world_left is not None

    @property
    def flow_px(self) -> float:
        """Median displacement of the points in the left image."""
        return self.error_px(np.eye(4))


def step_between(
    first: StereoPair,
    second: StereoPair,
    T_second_first: Array | None = None,
    num_corners: int = NUM_CORNERS,
) -> Step | None:
    """The step between two pairs; None if the images show none.

    Parameters
    ----------
    first, second : StereoPair
    T_second_first : (4, 4), optional
        Motion used to predict the corners.
    num_corners : int
        Approximate number of corners to track.
    """
    if first.rig != second.rig:
        return None
    tracks = track(first, second, T_second_first, num_corners)
    agreeing = agreeing_tracks(tracks, first.rig)
    if agreeing is None:
        return None
    refined = refine_motion(agreeing[0], tracks.select(agreeing[1]), first.rig)
    if refined is None:
        return None
    step = Step(
        first=first,
        second=second,
        tracks=tracks.select(agreeing[1]),
        all_tracks=tracks,
        T_second_first=refined,
        num_corners=num_corners,
    )
    return step if step.flow_px > max(MIN_FLOW_PX, 2.0 * step.error_px(refined)) else None
