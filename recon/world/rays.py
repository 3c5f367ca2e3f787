"""Ray and distance queries on triangles: the only user of Open3D's raycasting scenes."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.libraries import load_open3d
from recon.world.solids import Triangles


class RayScene:
    """Triangles of several parts, numbered consecutively; there may be none."""

    def __init__(self, parts: Iterable[Triangles]) -> None:
        self._corners = np.concatenate([np.empty((0, 3, 3)), *(part.corners for part in parts)])
        self._scene = _build(self._corners)

    @classmethod
    def of_corners(cls, corners: Array) -> "RayScene":
        """The scene of triangles (T, 3, 3) without looks."""
        scene = cls(())
        scene._corners, scene._scene = corners, _build(corners)
        return scene

    def first_hit(self, rays: NDArray[np.float32], reach: float) -> NDArray[np.int32]:
        """Number (N,) of the first triangle that each ray (N, 6) hits within `reach`, -1 = none.

        A ray is origin and direction; `reach` is in multiples of the direction's length.
        """
        return _first_hit(self._scene, rays, reach)

    def first_hit_without(
        self, hidden: NDArray[np.bool_], rays: NDArray[np.float32], reach: float
    ) -> NDArray[np.int32]:
        """The same, ignoring the `hidden` triangles (T,)."""
        number = np.append(np.flatnonzero(~hidden), -1).astype(np.int32)
        return number[_first_hit(_build(self._corners[~hidden]), rays, reach)]

    def distance(self, points: Array) -> Array:
        """(N,) distance of points (N, 3) to the nearest triangle, infinite if there is none."""
        if self._scene is None:
            return np.full(len(points), np.inf)
        query = load_open3d().core.Tensor.from_numpy(points.astype(np.float32))
        distance: Array = self._scene.compute_distance(query).numpy().astype(np.float64)
        return distance

    def encloses(self, points: Array) -> NDArray[np.bool_]:
        """Mask of the points (N, 3) inside: their rays cross an odd number of triangles."""
        if self._scene is None:
            return np.zeros(len(points), bool)
        query = load_open3d().core.Tensor.from_numpy(points.astype(np.float32))
        inside: NDArray[np.bool_] = self._scene.compute_occupancy(query, nsamples=3).numpy() > 0.5
        return inside

    def covers(self, points_xz: Array) -> NDArray[np.bool_]:
        """Mask of the vertical lines through x, z (N, 2) that hit a triangle."""
        rays = np.zeros((len(points_xz), 6), np.float32)
        rays[:, [0, 2]] = points_xz
        rays[:, 1] = self._corners[..., 1].max(initial=0.0) + 1.0
        rays[:, 4] = -1.0
        return self.first_hit(rays, np.inf) >= 0


def _build(corners: Array) -> Any:
    if not len(corners):
        return None
    o3d = load_open3d()
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor(corners.reshape(-1, 3).astype(np.float32)),
        o3d.core.Tensor(np.arange(3 * len(corners), dtype=np.uint32).reshape(-1, 3)),
    )
    return scene


def _first_hit(scene: Any, rays: NDArray[np.float32], reach: float) -> NDArray[np.int32]:
    if scene is None:
        return np.full(len(rays), -1, np.int32)
    hits = scene.cast_rays(load_open3d().core.Tensor.from_numpy(rays))
    # Open3D's index for "no triangle" is 2^32 - 1, which reads as -1.
    triangle = hits["primitive_ids"].numpy().view(np.int32)
    return np.where(hits["t_hit"].numpy() <= reach, triangle, np.int32(-1))
