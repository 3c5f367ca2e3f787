"""Homing: an agent with motion errors ends where it began, which closes the loop of its walk."""

import numpy as np

from recon.exploration.paths import plan, unexplored
from recon.exploration.state import State, Walk
from recon.exploration.viewpoints import azimuth_of, look_along
from recon.records import View


def way_home(first: View, state: State) -> Walk | None:
    """The walk back to the first view; None if the agent is as close to it as it can be."""
    start, ahead = first.position[[0, 2]], (first.target - first.position)[[0, 2]]
    paths = plan(state, unexplored(state.floor, state.obstacles))
    place = start if paths.reaches(start) else paths.nearest(start)
    if np.hypot(*(place - state.place)) < state.scales.cell:
        return None
    return look_along(paths, place, azimuth_of(ahead), state)
