"""The two sides of what is explored: what the agent asks of it, and what a referee knows of it."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.records import StereoPair, View
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
    """What is explored, where the truth about it is known."""

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
