"""The two sides of what is explored: what the agent asks of it, and what a referee knows of it."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.records import StereoPair, View
from recon.settings import Settings
from recon.world.objects import TrueObject


class Explorable(Protocol):
    """A place that stereo pairs can be taken in: a simulated world, a robot, a recording."""

    def start(self) -> View:
        """The view that the exploration begins with."""
        ...

    def take(self, view: View) -> StereoPair:
        """The pair of a view, rectified, with the pose that it was taken from."""
        ...


@runtime_checkable
class KnownWorld(Explorable, Protocol):
    """An explored place whose truth is known."""

    objects: Sequence[TrueObject]

    def body_clearance(self, places_xz: ArrayLike, height: float) -> NDArray[np.float64]:
        """(N,) distance of upright axes at x, z (N, 2) to the nearest surface, ground excluded.

        The axes reach from the ground up to `height`.
        """
        ...

    def is_inside(self, positions: ArrayLike) -> NDArray[np.bool_]:
        """(N,) whether points (N, 3) lie inside an object."""
        ...

    def free_ground(self, cell_size: float) -> NDArray[np.bool_]:
        """(X, Z) floor cells whose middle no object stands on or hangs over."""
        ...


def start_of(source: Explorable, settings: Settings) -> View:
    """The first view: that of the source, but for what the settings say of it."""
    start, wanted = source.start(), settings.exploration
    position, gaze = start.position, start.target - start.position
    if wanted.start_position is not None:
        x, *y, z = wanted.start_position
        position = np.array([x, *(y or position[1:2]), z])
    if wanted.start_heading_deg is not None:
        heading = math.radians(wanted.start_heading_deg)
        gaze = math.hypot(*gaze) * np.array([math.sin(heading), 0.0, -math.cos(heading)])
    return replace(start, position=position, target=position + gaze)
