"""Trust: how well features distinguish the places of a map, judged by the map's own places.

Repeating texture makes different places look alike: then features alone say nothing. If all places
that look alike are the same place, features are nearly sufficient.
"""

import math

import numpy as np

from recon.geometry import invert
from recon.localisation.atlas import Atlas
from recon.sequences.odometry.places import meet

MIN_AGREEING = 24
"""Minimum number of agreeing points of two places that look alike."""
NUM_PLACES, NUM_ALIKE = 24, 5
"""Places that are tested, and the most similar others with which each is compared."""
SAME_SHARE = 0.2
"""Maximum position error of a correct recognition, as a share of the place's depth."""


def trust_in(atlas: Atlas) -> float:
    """Log odds that places that look alike are the same place; at least 0."""
    if len(atlas) < 2:
        return 0.0
    summaries, right, wrong = atlas.summaries, 0.5, 0.5
    for row in np.unique(np.linspace(0, len(atlas) - 1, NUM_PLACES).astype(np.intp)):
        likeness = summaries @ summaries[row]
        likeness[row] = -1.0
        for other in np.argsort(-likeness, kind="stable")[:NUM_ALIKE]:
            is_right = _is_right(atlas, int(other), int(row)) if other != row else None
            right, wrong = right + (is_right is True), wrong + (is_right is False)
    return max(0.0, math.log(right / wrong))


def _is_right(atlas: Atlas, first: int, second: int) -> bool | None:
    """True if two places that look alike are the same; None if they do not look alike."""
    met = meet(atlas.places[first], atlas.places[second])
    if met is None or met.num_agreeing < MIN_AGREEING:
        return None
    T_world_second = atlas.T_world_left[first] @ invert(met.T_second_first)
    off = T_world_second[:3, 3] - atlas.T_world_left[second, :3, 3]
    return bool(np.linalg.norm(off) < SAME_SHARE * atlas.places[second].depth)
