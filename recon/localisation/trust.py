"""Trust: how far features tell places apart in a map, by the map's own places.

Texture that repeats makes places look alike that are not; on a map of such places features alone
say nothing, on one where all that look alike are one place they say nearly all.
"""

import math

import numpy as np

from recon.geometry import invert
from recon.localisation.atlas import Atlas
from recon.sequences.odometry.places import meet

MIN_AGREEING = 24
"""Points that have to agree with those of a place, before it is taken for the same."""
NUM_PLACES, NUM_ALIKE = 24, 5
"""Places that are tried, and others, most like each, that they are held against."""
SAME_SHARE = 0.2
"""Of its depth, that a place is off at most where it was rightly known again."""


def trust_in(atlas: Atlas) -> float:
    """Logarithm of how often places that look alike are one, over how often not; at least 0."""
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
    """True where two places look alike and are; None where they do not look alike."""
    met = meet(atlas.places[first], atlas.places[second])
    if met is None or met.num_agreeing < MIN_AGREEING:
        return None
    T_world_second = atlas.T_world_left[first] @ invert(met.T_second_first)
    off = T_world_second[:3, 3] - atlas.T_world_left[second, :3, 3]
    return bool(np.linalg.norm(off) < SAME_SHARE * atlas.places[second].depth)
