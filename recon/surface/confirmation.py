"""Depths confirmed by other views; moving objects and wrong matches are not."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.geometry import invert
from recon.surface.depth import Camera, DepthMap, Floats

NUM_NEIGHBOURS = 6
_NUM_SIGMAS = np.float32(2.5)
_NUM_NEEDED = 2
_FEW = 2
"""Number of views up to which one confirmation of a point is enough."""


def confirmed(view: DepthMap, others: Sequence[DepthMap]) -> DepthMap:
    """The depths of a view confirmed by others, with the number of agreeing views.

    Another view confirms a point if its own depth is within 2.5 joint sigmas, contradicts it if it
    sees a point behind, and does not see it if its depth is unknown or occluded. Two have to
    confirm, one if only one or two see the point, none if none does; and no more may contradict
    than confirm.
    """
    counts = np.zeros((3, *view.depth.shape), np.uint8)
    for other in _nearest(view, others):
        T_other_view = invert(other.T_world_left) @ view.T_world_left
        _ask(
            view.depth, view.sigma, view.camera, other.depth, other.sigma, other.camera,
            T_other_view, counts,
        )  # fmt: skip
    agreeing, against, looking = counts
    needed = np.minimum(np.where(looking <= _FEW, 1, _NUM_NEEDED), looking)
    kept = view.valid_mask & (agreeing >= needed) & (against <= agreeing)
    return replace(view.where(kept), num_views=np.where(kept, agreeing + 1, 0).astype(np.uint8))


class Confirmation:
    """A stream of views, each confirmed by those before and after it.

    Memory holds as many views as a view has neighbours on both sides.
    """

    def __init__(self) -> None:
        self._views: list[DepthMap] = []
        self._num_done = 0
        self._num_dropped = 0

    def add(self, view: DepthMap) -> Iterator[DepthMap]:
        """Add the next view; yield the one that now has all its neighbours, confirmed."""
        self._views.append(view)
        if self._num_seen - self._num_done > NUM_NEIGHBOURS:
            yield self._next()

    def finish(self) -> Iterator[DepthMap]:
        """Yield the views that still waited for others."""
        while self._num_done < self._num_seen:
            yield self._next()

    @property
    def _num_seen(self) -> int:
        return self._num_dropped + len(self._views)

    def _next(self) -> DepthMap:
        row = self._num_done - self._num_dropped
        found = confirmed(self._views[row], self._views[:row] + self._views[row + 1 :])
        self._num_done += 1
        if row >= NUM_NEIGHBOURS:
            self._views.pop(0)
            self._num_dropped += 1
        return found


def _nearest(view: DepthMap, others: Sequence[DepthMap]) -> list[DepthMap]:
    """The nearest views with a similar viewing direction."""
    ahead = view.T_world_left[:3, 2]
    alike = [other for other in others if other.T_world_left[:3, 2] @ ahead > 0]
    distances = [float(np.linalg.norm(other.position - view.position)) for other in alike]
    return [alike[row] for row in np.argsort(distances, kind="stable")[:NUM_NEIGHBOURS]]


@njit(cache=True, nogil=True, error_model="numpy")
def _ask(  # noqa: PLR0913 - two views and the motion between them
    depth: Floats,
    sigma: Floats,
    camera: Camera,
    other_depth: Floats,
    other_sigma: Floats,
    other_camera: Camera,
    T_other_view: NDArray[np.float64],
    counts: NDArray[np.uint8],
) -> None:
    """Count for every pixel if another view agrees, disagrees, and sees it."""
    focal, cx, cy = camera
    T = T_other_view
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            z = np.float64(depth[v, u])
            if not np.isfinite(z):
                continue
            x, y = (u - cx) / focal * z, (v - cy) / focal * z
            point = (
                T[0, 0] * x + T[0, 1] * y + T[0, 2] * z + T[0, 3],
                T[1, 0] * x + T[1, 1] * y + T[1, 2] * z + T[1, 3],
                T[2, 0] * x + T[2, 1] * y + T[2, 2] * z + T[2, 3],
            )
            row, column = _pixel(point, other_camera, other_depth.shape)
            if row >= 0 and np.isfinite(other_depth[row, column]):
                difference = other_depth[row, column] - point[2]
                a, b = sigma[v, u], other_sigma[row, column]
                limit = _NUM_SIGMAS * np.sqrt(a * a + b * b)
                counts[0, v, u] += abs(difference) <= limit
                counts[1, v, u] += difference > limit
                counts[2, v, u] += difference >= -limit


@njit(cache=True, nogil=True, error_model="numpy")
def _pixel(
    point: tuple[float, float, float], camera: Camera, shape: tuple[int, int]
) -> tuple[int, int]:
    """Row and column at which a camera sees a point; -1 if it does not."""
    focal, cx, cy = camera
    if point[2] <= 0:
        return -1, -1
    column, row = focal * point[0] / point[2] + cx, focal * point[1] / point[2] + cy
    if not (-0.5 <= column < shape[1] - 0.5 and -0.5 <= row < shape[0] - 0.5):
        return -1, -1
    return int(np.floor(row + 0.5)), int(np.floor(column + 0.5))
