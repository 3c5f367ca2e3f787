"""Settings of recorded sequences."""

from typing import Literal

from recon.settings.stage import Count, Positive, table


@table
class SequenceSettings:
    """Selection of the pairs of a recording, and the source of their poses."""

    format: str = "auto"
    """auto, folder, kitti, euroc, middlebury, ring, video, bag, or a plug-in's name."""
    poses: Literal["given", "estimated", "none"] = "given"
    """Those that the recording brings, those of stereo odometry, or none."""
    every: Count = 1
    """Every so many pairs are read."""
    roi: tuple[int, int, int, int] | None = None
    """x, y, width, height in pixels of the rectified images: the rest is cut off both."""
    left_topic: str | None = None
    """Topic of a bag's left images; by its name where not given."""
    right_topic: str | None = None
    """Topic of a bag's right images; by its name where not given."""
    max_confirmed_depth: Positive = 30.0
    """Only points nearer than this, world units, count for the share that other pairs confirm."""
    only_confirmed: bool = False
    """Keep only the points that the pair before or after confirms; a single pair keeps all."""
