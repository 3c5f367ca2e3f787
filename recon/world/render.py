"""Pictures by ray casting: Open3D finds what a ray hits, one compiled loop gives it its colour.

Textures are read through mipmaps everywhere; edges, where mipmaps do not help, are supersampled.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.libraries import load_open3d
from recon.settings.world import RenderSettings
from recon.world.sampling import shade
from recon.world.solids import Triangles
from recon.world.textures import TextureAtlas

SKY_RGB = (196.0, 212.0, 228.0)
"""Pale, so that outlines that mix with it keep the hue of their object."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Camera:
    """Rays of a picture, in the world: one a pixel, affine in the pixel's (u, v).

    A ray starts at ``origin + u origin_u + v origin_v`` and goes along ``direction + u direction_u
    + v direction_v``; depth counts in the length of its direction.
    """

    width: int
    height: int
    near: float
    far: float
    origin: Array
    direction: Array
    steps: Array
    """(4, 3) origin u, direction u, origin v, direction v."""

    def rays(self, points_px: Array) -> tuple[Array, Array]:
        """Origins and directions (N, 3) through image points (N, 2)."""
        u, v = points_px[:, :1], points_px[:, 1:]
        return (
            self.origin + u * self.steps[0] + v * self.steps[2],
            self.direction + u * self.steps[1] + v * self.steps[3],
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picture:
    """What a camera sees."""

    rgb: NDArray[np.uint8]
    """(H, W, 3)."""
    depth: Array
    """(H, W) at the middle of each pixel, NaN = nothing within near and far."""
    visual: NDArray[np.int32]
    """(H, W) number of the visual, -1 = none."""


class Raycaster:
    """All triangles of a world, ready to be looked at.

    Parameters
    ----------
    parts : triangles of each visual
    texture : of each visual its place in `atlas`, -1 = none
    atlas : the textures
    settings : the renderer's
    """

    def __init__(
        self,
        parts: list[Triangles],
        texture: list[int],
        atlas: TextureAtlas,
        settings: RenderSettings,
    ) -> None:
        counts = [len(part.corners) for part in parts]
        self._visual = np.repeat(np.arange(len(parts), dtype=np.int32), counts)
        self._texture = np.repeat(np.array(texture, dtype=np.int32), counts)
        self._facets = np.concatenate([np.empty((0, 26)), *(_facets(part) for part in parts)])
        self._atlas = (atlas.texels, atlas.start, atlas.shape)
        self._settings = settings
        self._scene = cast_scene(parts)

    def look(self, camera: Camera) -> Picture:
        """The picture of a camera."""
        height, width = camera.height, camera.width
        v, u = np.mgrid[:height, :width].astype(np.float64)
        pixels = np.column_stack([u.ravel(), v.ravel()])
        triangle, depth, colour = self._cast(camera, pixels, 1)
        side = self._settings.supersampling
        if side > 1:
            edge = np.flatnonzero(_edges(self._surface_id(triangle).reshape(height, width)))
            samples = (pixels[edge][:, None] + _offsets(side)).reshape(-1, 2)
            _, _, fine = self._cast(camera, samples, side)
            colour[edge] = fine.reshape(len(edge), side * side, 3).mean(axis=1)
        return Picture(
            rgb=np.rint(colour).astype(np.uint8).reshape(height, width, 3),
            depth=depth.reshape(height, width),
            visual=np.where(triangle < 0, -1, self._visual[triangle]).reshape(height, width),
        )

    def _cast(
        self, camera: Camera, points_px: Array, side: int
    ) -> tuple[NDArray[np.int32], Array, Array]:
        """Triangle (N,), depth (N,) and colour (N, 3) at image points that are 1 / side apart."""
        origins, directions = camera.rays(points_px)
        triangle = first_hit(self._scene, origins, directions, camera.near, camera.far)
        depth, colour = np.empty(len(points_px)), np.empty((len(points_px), 3))
        shade(
            (origins, directions, camera.steps / side),
            triangle,
            (self._facets, self._texture),
            self._atlas,
            (np.array(SKY_RGB), 0.0),
            depth,
            colour,
        )
        return triangle, depth, colour

    def _surface_id(self, triangle: NDArray[np.int32]) -> NDArray[np.int32]:
        return np.where(triangle < 0, -1, self._visual[triangle])


def cast_scene(parts: list[Triangles]) -> Any:
    """Open3D's ray casting scene of all parts; None where there is no triangle."""
    corners = np.concatenate([np.empty((0, 3, 3)), *(part.corners for part in parts)])
    if not len(corners):
        return None
    o3d = load_open3d()
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor(corners.reshape(-1, 3).astype(np.float32)),
        o3d.core.Tensor(np.arange(3 * len(corners), dtype=np.uint32).reshape(-1, 3)),
    )
    return scene


def first_hit(
    scene: Any, origins: Array, directions: Array, near: float, far: float
) -> NDArray[np.int32]:
    """Number of the first triangle each ray meets between `near` and `far`, -1 = none."""
    if scene is None:
        return np.full(len(origins), -1, np.int32)
    o3d = load_open3d()
    rays = np.empty((len(origins), 6), np.float32)
    rays[:, :3] = origins + near * directions
    rays[:, 3:] = directions
    hits = scene.cast_rays(o3d.core.Tensor.from_numpy(rays))
    reached = hits["t_hit"].numpy() <= far - near
    return np.where(reached, hits["primitive_ids"].numpy().astype(np.int32), np.int32(-1))


def _facets(part: Triangles) -> Array:
    """(T, 26) first corner, normal, u v r g b there, and the five gradients of those."""
    first = part.corners[:, 0]
    edges = part.corners[:, 1:] - part.corners[:, :1]
    values = np.concatenate([part.uv, part.colours], axis=2)
    normal = np.cross(edges[:, 0], edges[:, 1])
    # Gradients in the plane: the values' rise along both edges and none along the normal.
    frame = np.concatenate([edges, normal[:, None]], axis=1)
    rise = np.concatenate([values[:, 1:] - values[:, :1], np.zeros_like(values[:, :1])], axis=1)
    gradients = np.swapaxes(np.linalg.solve(frame, rise), 1, 2)
    return np.concatenate([first, normal, values[:, 0], gradients.reshape(-1, 15)], axis=1)


def _edges(surface: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Pixels (H, W) with a neighbour that shows another surface."""
    edge = np.zeros(surface.shape, bool)
    across, down = surface[:, 1:] != surface[:, :-1], surface[1:] != surface[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return edge


def _offsets(side: int) -> Array:
    """(side^2, 2) places inside a pixel, round its middle."""
    steps = (np.arange(side) + 0.5) / side - 0.5
    v, u = np.meshgrid(steps, steps, indexing="ij")
    return np.column_stack([u.ravel(), v.ravel()])
