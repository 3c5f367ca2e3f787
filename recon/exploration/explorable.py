"""Interfaces of an explored world: for the agent, and for the referee, who knows the truth."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import check_type
from recon.records import StereoPair, View
from recon.settings import Settings
from recon.world.objects import TrueObject


class Explorable(Protocol):
    """A source of stereo pairs for requested views: a simulated world, a robot, a recording."""

    def start(self) -> View:
        """The first view of the exploration."""
        ...

    def take(self, view: View) -> StereoPair:
        """The rectified pair of a view, with the pose at which it was taken."""
        ...


@runtime_checkable
class KnownWorld(Explorable, Protocol):
    """An explored world whose truth is known."""

    objects: Sequence[TrueObject]

    def body_clearance(self, places_xz: ArrayLike, height: float) -> NDArray[np.float64]:
        """Distances (N,) of vertical axes at x, z (N, 2) to the nearest surface except the ground.

        The axes extend from the ground up to `height`.
        """
        ...

    def is_inside(self, positions: ArrayLike) -> NDArray[np.bool_]:
        """Mask (N,) of the points (N, 3) inside an object."""
        ...

    def free_ground(self, cell_size: float) -> NDArray[np.bool_]:
        """Mask (X, Z) of floor cells whose centre is not on or under an object."""
        ...


def start_of(source: Explorable, settings: Settings) -> View:
    """The first view: that of the source, with overrides from the settings."""
    start, wanted = source.start(), settings.exploration
    check_type("start", start, View)
    position, gaze = start.position, start.target - start.position
    if wanted.start_position is not None:
        x, *y, z = wanted.start_position
        position = np.array([x, *(y or position[1:2]), z])
    if wanted.start_heading_deg is not None:
        heading = math.radians(wanted.start_heading_deg)
        gaze = math.hypot(*gaze) * np.array([math.sin(heading), 0.0, -math.cos(heading)])
    return replace(start, position=position, target=position + gaze)
