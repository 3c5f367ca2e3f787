"""Auto focus: the cameras converge on the nearest object and match the disparities around it.

The thesis leaves it to future work: "the camera parameters should be chosen by the distance of the
objects". A first pair measures the distance, a second one is used.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from recon.camera import StereoRig
from recon.mapping.pair import match_points
from recon.records import StereoPair, View
from recon.settings import Settings, given_tree, updated

Take = Callable[[View], StereoPair]

NEAREST_SHARE = 0.02
"""Share of the points closer than the nearest object, which are noise."""
MIN_POINTS = 20
"""Fewer points are not an object."""
ROOM = 1.5
"""Objects closer than the nearest one by this factor are still matched."""
ENDS_PX = 1
"""Extra disparities searched at both ends."""


def focusing(take: Take, settings: Settings) -> Take:
    """Make `take` look twice: first with the requested gaze, then focused.

    If the first look shows nothing, its pair is returned.
    """
    if not settings.eyes.auto_focus:
        return take

    whole = settings.matching.min_disparity, settings.matching.max_disparity

    def take_focused(view: View) -> StereoPair:
        pair = take(view)
        distance = nearest_distance(pair, settings)
        if distance is None:
            return replace(pair, disparity_range=whole)
        ahead = (view.target - view.position) / np.linalg.norm(view.target - view.position)
        focused = take(replace(view, target=view.position + distance * ahead))
        return replace(focused, disparity_range=range_of(focused.rig, distance))

    return take_focused


def nearest_distance(pair: StereoPair, settings: Settings) -> float | None:
    """Distance to the nearest object in a pair; None if there is none."""
    seen = match_points(replace(pair, T_world_left=np.eye(4)), settings).cloud
    if len(seen) < MIN_POINTS:
        return None
    return float(np.quantile(np.linalg.norm(seen.points, axis=1), NEAREST_SHARE))


def range_of(rig: StereoRig, distance: float) -> tuple[int, int]:
    """The disparities from infinity to slightly closer than the nearest object, in whole pixels."""
    low, high = rig.disparity_offset_px, float(rig.disparity(distance / ROOM))
    return math.floor(low) - ENDS_PX, math.ceil(high) + ENDS_PX


def focusable(settings: Settings) -> Settings:
    """The settings with the search range left to the pairs; unchanged without auto focus."""
    if not settings.eyes.auto_focus:
        return settings
    tree = given_tree(settings)
    ends = ("min_disparity", "max_disparity")
    matching = {name: value for name, value in tree["matching"].items() if name not in ends}
    return updated(Settings(), {**tree, "matching": matching})
