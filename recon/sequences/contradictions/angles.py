"""The angle between the cameras, from the motion of the rig."""

from collections.abc import Sequence

import numpy as np

from recon.sequences.calibration.selfcalibration import fitted_offset
from recon.sequences.contradictions.finding import Finding
from recon.sequences.contradictions.steps import Step

MIN_TRACKS = 200
"""Over all steps; fewer lie on few objects."""
MAX_OFFSET_PX = 2.0
"""Maximum offset of all disparities; KITTI has 0.3."""
MIN_GAIN = 0.1
"""Share of the robust cost that the offset must save."""


def angle_finding(steps: Sequence[Step]) -> Finding | None:
    """An offset of all disparities with which the points fit the motion of the rig far better.

    A turn of one camera about the vertical, or a wrong principal point, causes it; a rig at rest
    does not show it.
    """
    if sum(len(step.all_tracks) for step in steps) < MIN_TRACKS:
        return None
    rig = steps[0].first.rig
    fit = fitted_offset([step.all_tracks for step in steps], rig)
    if abs(fit.offset_px) < MAX_OFFSET_PX or fit.gain < MIN_GAIN:
        return None
    return Finding(
        code="angle-differs",
        text="the angle between the cameras is not the calibrated one: with disparities "
        f"{fit.offset_px:+.1f} px the points fit the motion of the rig, as after a turn of one "
        f"camera by {np.degrees(abs(fit.offset_px) / rig.focal_px):.2f} degrees; recalibrate",
    )
