"""Clearance of an upright body: the distance of its axis from the surfaces of a world."""

from collections.abc import Sequence

import numpy as np

from recon.geometry import Array
from recon.world.rays import RayScene
from recon.world.solids import Triangles

FLATNESS = 1e-3
"""Factor that flattens heights beside the body; 0 would leave triangles without area."""


class BodyRoom:
    """Surfaces, transformed for distances to an upright axis from the ground to a height.

    With heights beside the axis flattened, and everything above lowered accordingly, the distance
    to the axis becomes the distance to a point.
    """

    def __init__(self, parts: Sequence[Triangles], height: float) -> None:
        self._height = height
        corners = np.concatenate([np.empty((0, 3, 3)), *(part.corners for part in parts)])
        above, rest = split_at(corners, height)
        beside, below = split_at(rest, 0.0)
        above[..., 1] -= (1.0 - FLATNESS) * height
        beside[..., 1] *= FLATNESS
        self._scene = RayScene.of_corners(np.concatenate([above, beside, below]))

    def clearance(self, places_xz: Array) -> Array:
        """(N,) distance of the axes at x, z (N, 2) to the nearest surface."""
        x, z = places_xz.T
        middle = np.full(len(x), 0.5 * FLATNESS * self._height)
        return self._scene.distance(np.column_stack([x, middle, z]))


def split_at(corners: Array, height: float) -> tuple[Array, Array]:
    """Cut triangles (T, 3, 3) by a level plane into those above and those below it."""
    is_above = corners[..., 1] > height
    count = is_above.sum(axis=1)
    lone_above, lone_below = corners[count == 1], corners[count == 2]
    tip, base = _cut(_turned(lone_above, is_above[count == 1]), height)
    foot, top = _cut(_turned(lone_below, ~is_above[count == 2]), height)
    above = np.concatenate([corners[count == 3], tip, top])
    below = np.concatenate([corners[count == 0], foot, base])
    return above, below


def _turned(corners: Array, is_lone: Array) -> Array:
    """The triangles, starting with the corner that is alone on its side."""
    order = (is_lone.argmax(axis=1)[:, None] + np.arange(3)) % 3
    return np.take_along_axis(corners, order[..., None], axis=1)


def _cut(corners: Array, height: float) -> tuple[Array, Array]:
    """The triangle (T, 3, 3) at the first corner, and two (2 T, 3, 3) of the rest."""
    first, second, third = corners[:, 0], corners[:, 1], corners[:, 2]
    a, b = (_crossing(first, other, height) for other in (second, third))
    rest = [np.stack([a, second, third], axis=1), np.stack([a, third, b], axis=1)]
    return np.stack([first, a, b], axis=1), np.concatenate(rest)


def _crossing(start: Array, end: Array, height: float) -> Array:
    """Points (T, 3) where edges cross the plane."""
    share = (height - start[:, 1]) / (end[:, 1] - start[:, 1])
    point: Array = start + share[:, None] * (end - start)
    return point
