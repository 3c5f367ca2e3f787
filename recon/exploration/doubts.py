"""Doubts: what the agent views again before it goes on or ends."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import binary_closing, distance_transform_edt, label
from scipy.spatial.distance import cdist

from recon.exploration.floor import NEIGHBOURS, Array, Floor
from recon.exploration.obstacles import Obstacle
from recon.exploration.paths import unseen
from recon.exploration.scan import Detection
from recon.exploration.search import are_named
from recon.exploration.sides import widest_gap
from recon.exploration.state import State

CLOSE = 0.5
"""Distance of a second look, as a share of the usual one: errors of depth grow with its square."""
NEARBY = 1.25
"""Distance of a view, as a share of the usual one, up to which it shows most of a side."""
FAR = 0.8
"""Least distance of a look at a top, as a share of the usual one."""


def doubts(state: State) -> list[Detection]:
    """Obstacles that resemble a kind but have no sure name, and ground that may hide one."""
    least = state.scales.unknown_clearance
    hiding = hiding_places(state.floor, state.obstacles, least)
    named = [*doubtful(state.obstacles), *strange(state.obstacles)]
    return [*named, *hiding, *elsewhere(state)]


def doubtful(obstacles: Iterable[Obstacle]) -> list[Detection]:
    """Obstacles that resemble a kind but have no sure name, as if no view had seen them."""
    return [_once_more(one.centre, one.radius) for one in obstacles if one.is_doubtful]


def strange(obstacles: Sequence[Obstacle]) -> list[Detection]:
    """Obstacles that resemble nothing where most have a label.

    One more look is enough unless it shows much more, such as a board as high as the eyes, which is
    only seen from nearby: then its other sides are worth one as well.
    """
    if not are_named(obstacles):
        return []
    odd = [one for one in obstacles if one.is_strange]
    return [(_once_more if one.is_growing else _one_look)(one.centre, one.radius) for one in odd]


def seen_from_afar(obstacles: Sequence[Obstacle], clearance: float) -> list[Obstacle]:
    """Obstacles that resemble nothing where most have a label.

    They are as if seen only by the views from nearby: a wall at some distance has few cells, and
    the roof above it none.

    Parameters
    ----------
    clearance : float
        Usual distance of a view, world units.
    """
    if not are_named(obstacles):
        return []
    odd = [one for one in obstacles if one.is_strange]
    reach = NEARBY * clearance
    return [replace(one, bearings_rad=one.bearings_rad[one.away <= reach]) for one in odd]


def cut_off(obstacles: Iterable[Obstacle]) -> list[Obstacle]:
    """Obstacles that resemble nothing and whose top was not seen from half of all directions.

    They are as if seen only by the views that show their tops: a tree of which only the trunk was
    in view resembles nothing.
    """
    odd = [one for one in obstacles if one.is_strange]
    whole = [replace(one, bearings_rad=one.bearings_rad[one.is_whole]) for one in odd]
    return [one for one in whole if widest_gap(one.bearings_rad) > math.pi]


def elsewhere(state: State) -> Iterator[Detection]:
    """The places left for detections that are not where they seemed to be.

    From far away something thin or low seems to be where only its nearest or farthest points are.
    One look is enough: its ground is then seen as free, or the obstacle is in the map.
    """
    centres = np.array([one.centre for one in state.obstacles]).reshape(-1, 2)
    reach = np.array([one.radius for one in state.obstacles]) + state.scales.same_obstacle
    for one in state.refuted:
        is_mapped = (cdist(one.places, centres) <= reach + one.radius).any()
        left = [place for place in one.places if not one.is_refuted(state.floor, place)]
        if left and not is_mapped:
            middle, width = (left[0] + left[-1]) / 2.0, math.dist(left[0], left[-1])
            yield _one_look(middle, one.radius + width / 2.0)


def hiding_places(floor: Floor, obstacles: Iterable[Obstacle], least: float) -> Iterator[Detection]:
    """Patches of unknown ground with a foot of something and room for it.

    An edge on plain ground is taken for a foot as well, but hides nothing: the ground behind it is
    seen from other sides. Of a table far away only the legs are seen, so that cells between small
    patches belong to them.

    Parameters
    ----------
    least : float
        Minimum distance of the middle of a patch from the explored ground, world units.
    """
    unknown = unseen(floor, obstacles)
    unknown |= binary_closing(unknown, NEIGHBOURS)
    depth = distance_transform_edt(unknown) * floor.cell_size
    number, num_patches = label(unknown, NEIGHBOURS)
    for patch in range(1, num_patches + 1):
        cells = np.argwhere(number == patch)
        rows = tuple(cells.T)
        if depth[rows].max() > least and floor.barred[rows].any():
            points = floor.centres(cells)
            centre = (points.min(axis=0) + points.max(axis=0)) / 2.0
            radius = float(np.hypot(*(points - centre).T).max())
            yield _once_more(centre, radius)


def _once_more(centre: Array, radius: float) -> Detection:
    """A disc on the floor to look at as if no view had seen it."""
    return Detection(centre=centre, radius=radius, distance=0.0, sigma=0.0)


def _one_look(centre: Array, radius: float) -> Detection:
    """The same, but one view of any side is enough."""
    return replace(_once_more(centre, radius), sigma=math.inf)
