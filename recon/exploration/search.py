"""A search: what to look for, how to view it, and the views so far that were meant to show it."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from recon.exploration.floor import Array
from recon.exploration.obstacles import Obstacle
from recon.exploration.scan import Detection
from recon.records import UNKNOWN

MAX_LOOKS = 2
"""A side that was not seen well in this number of views is usually given up."""
MAX_WANTED = 12
"""Maximum number of obstacles of a round, the nearest: there are stops for two views of each."""

Wanted = Sequence[Obstacle | Detection]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Look:
    """A view that was meant to show a side of an obstacle."""

    place: Array
    """(2,) x, z from which it was taken."""
    centre: Array
    """(2,) x, z of the obstacle, as known at that time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """Things to look for, and the way to view them."""

    wanted: Wanted = ()
    clearance: float
    """Distance from which obstacles are viewed, world units."""
    reach: float
    """Distance up to which a view shows an obstacle well enough, world units."""
    least: float = 0.0
    """Distance from which on a view shows an obstacle well enough, world units."""
    looks: list[Look] = field(default_factory=list)
    """Earlier views that were meant to show these; the next one is added."""
    max_looks: int = MAX_LOOKS
    """A side that was not seen well in this number of views is given up."""
    expects_names: bool = True
    """False if an obstacle not yet named is expected to get no sure label either."""

    def nearest(self, place: Array) -> Wanted:
        """The wanted things nearest to a position (2,)."""
        return sorted(self.wanted, key=lambda one: math.dist(one.centre, place))[:MAX_WANTED]


def are_nameable(obstacles: Iterable[Obstacle]) -> bool:
    """True unless most of the obstacles named so far have no sure label."""
    sure = [one.is_sure for one in obstacles if one.found is not None]
    return 2 * sum(sure) >= len(sure)


def are_named(obstacles: Iterable[Obstacle]) -> bool:
    """True unless most of the obstacles named so far have no label, sure or not."""
    labels = [one.found.label for one in obstacles if one.found is not None]
    return 2 * labels.count(UNKNOWN) <= len(labels)
