"""Settings of recorded sequences."""

from typing import Literal

from recon.settings.stage import Count, Positive, table


@table
class SequenceSettings:
    """Selection of the pairs of a recording, and the source of their poses."""

    format: str = "auto"
    """auto, folder, kitti, euroc, middlebury, ring, video, bag, simulated, or a plug-in's name."""
    poses: Literal["given", "estimated", "none"] = "given"
    """Source of the poses: the recording, stereo odometry, or none."""
    every: Count = 1
    """Read every Nth pair."""
    roi: tuple[int, int, int, int] | None = None
    """Region of interest, x, y, width, height in pixels of the rectified images; both are cropped
    to it."""
    left_topic: str | None = None
    """Topic of a bag's left images; chosen by name if not given."""
    right_topic: str | None = None
    """Topic of a bag's right images; chosen by name if not given."""
    max_confirmed_depth: Positive = 30.0
    """Depth up to which points count towards the share confirmed by other pairs, world units."""
    only_confirmed: bool = False
    """Keep only points that the previous or the next pair confirms; a single pair keeps all."""
