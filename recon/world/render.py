"""Images by ray casting: Open3D finds the hits, a compiled loop computes the colours.

Textures are sampled through mipmaps; edges, where mipmaps do not help, are supersampled.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.settings.world import RenderSettings
from recon.world.rays import RayScene
from recon.world.sampling import Backdrop, cast_rays, shade
from recon.world.solids import Triangles
from recon.world.textures import build_atlas
from recon.world.visuals import NONE

SKY_RGB = (196.0, 212.0, 228.0)
"""Pale, so that outlines blended with it keep the hue of their object."""

ZENITH_RGB = (92.0, 142.0, 206.0)
"""Colour overhead, if the sky has a gradient."""

EDGE_STEP = 0.1
"""Relative depth difference of neighbouring pixels that makes an edge."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Camera:
    """Rays of an image, in the world; depth is in multiples of a ray's direction."""

    width: int
    height: int
    near: float
    far: float
    frame: Array
    """(6, 3) origin and direction of the ray of pixel (0, 0), then what one pixel further along u
    adds to each, then along v."""

    @property
    def is_parallel(self) -> bool:
        """True if all rays have the same direction."""
        return not self.frame[[3, 5]].any()


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """The look of a visual."""

    texture: int = NONE
    """Index of its image, -1 = none."""
    one_sided: bool = False
    """True if invisible from behind."""


class Raycaster:
    """All triangles of a world, ready for rendering.

    Parameters
    ----------
    parts : sequence of Triangles
        Of each visual.
    looks : sequence of Look
        Of each visual.
    images : sequence of (H, W, 3) uint8
        Textures.
    settings : RenderSettings
    """

    def __init__(
        self,
        parts: Sequence[Triangles],
        looks: Sequence[Look],
        images: Sequence[NDArray[np.uint8]],
        settings: RenderSettings,
    ) -> None:
        counts = [len(part.corners) for part in parts]
        # One longer than the triangles, so that index -1, the sky, maps to -1.
        self._visual = np.append(np.repeat(np.arange(len(parts)), counts), -1).astype(np.int32)
        self._texture = np.repeat(np.array([look.texture for look in looks], np.int32), counts)
        one_sided = np.repeat(np.array([look.one_sided for look in looks], bool), counts)
        self._one_sided = np.flatnonzero(one_sided)
        self._facets = np.concatenate([np.empty((0, 26)), *(_facets(part) for part in parts)])
        self._scene = RayScene(parts)
        atlas = build_atlas(images, settings.mipmaps)
        self._atlas = (atlas.texels, atlas.start, atlas.shape)
        self._backdrop = backdrop(settings)
        self._side = settings.supersampling

    def look(self, camera: Camera) -> NDArray[np.uint8]:
        """The image (H, W, 3) of a camera, its edges supersampled."""
        points_px = pixels(camera)
        triangle = self._hits(camera, points_px)
        depth, colour = self._shade(camera, points_px, 1, triangle)
        shape = (camera.height, camera.width)
        if self._side > 1:
            visual = self._visual[triangle].reshape(shape)
            edge = np.flatnonzero(_edges(visual, depth.reshape(shape)))
            samples = (points_px[edge][:, None] + pixel_offsets(self._side)).reshape(-1, 2)
            _, fine = self._shade(camera, samples, self._side, self._hits(camera, samples))
            colour[edge] = fine.reshape(len(edge), self._side**2, 3).mean(axis=1)
        image: NDArray[np.uint8] = np.rint(colour.clip(0.0, 255.0)).astype(np.uint8)
        return image.reshape(*shape, 3)

    def measure(self, camera: Camera) -> tuple[Array, NDArray[np.int32]]:
        """Depth (H, W), NaN = nothing, and number of the visual (H, W), -1 = none, at pixels."""
        points_px = pixels(camera)
        triangle = self._hits(camera, points_px)
        depth, _ = self._shade(camera, points_px, 1, triangle)
        shape = (camera.height, camera.width)
        return depth.reshape(shape), self._visual[triangle].reshape(shape)

    def _hits(self, camera: Camera, points_px: Array) -> NDArray[np.int32]:
        """Number (N,) of the triangle seen at each image point (N, 2), -1 = none."""
        rays = cast_rays(camera.frame, points_px, camera.near)
        hidden, reach = self._turned_away(camera), camera.far - camera.near
        if hidden.any():
            return self._scene.first_hit_without(hidden, rays, reach)
        return self._scene.first_hit(rays, reach)

    def _turned_away(self, camera: Camera) -> NDArray[np.bool_]:
        """Triangles (T,) that are not drawn because they are seen from behind."""
        corner, normal = np.split(self._facets[self._one_sided, :6], 2, axis=1)
        towards = camera.frame[1] if camera.is_parallel else corner - camera.frame[0]
        turned = np.zeros(len(self._facets), dtype=bool)
        turned[self._one_sided] = (normal * towards).sum(axis=1) > 0
        return turned

    def _shade(
        self, camera: Camera, points_px: Array, side: int, triangle: NDArray[np.int32]
    ) -> tuple[Array, Array]:
        """Depth (N,) and colour (N, 3) at image points that are 1 / side apart."""
        depth, colour = shade(
            camera.frame,
            points_px,
            1.0 / side,
            triangle,
            (self._facets, self._texture),
            self._atlas,
            self._backdrop,
        )
        return depth, colour


def _facets(part: Triangles) -> Array:
    """(T, 26) first corner, normal, u v r g b there, and the five gradients of those."""
    first = part.corners[:, 0]
    edges = part.corners[:, 1:] - part.corners[:, :1]
    values = np.concatenate([part.uv, part.colours], axis=2)
    normal = np.cross(edges[:, 0], edges[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # Gradients in the plane: the change along both edges, and none along the normal.
    frame = np.concatenate([edges, normal[:, None]], axis=1)
    rise = np.concatenate([values[:, 1:] - values[:, :1], np.zeros_like(values[:, :1])], axis=1)
    gradients = np.swapaxes(np.linalg.solve(frame, rise), 1, 2)
    return np.concatenate([first, normal, values[:, 0], gradients.reshape(-1, 15)], axis=1)


def _edges(visual: NDArray[np.int32], depth: Array) -> NDArray[np.bool_]:
    """Pixels (H, W) with a neighbour that shows another visual, or one much farther or nearer."""
    edge = np.zeros(visual.shape, bool)
    for a, b in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
        # For the sky, depth is NaN and the visual decides.
        differ = (visual[a] != visual[b]) | (np.abs(depth[a] - depth[b]) > EDGE_STEP * depth[a])
        edge[a] |= differ
        edge[b] |= differ
    return edge


def pixels(camera: Camera) -> Array:
    """Image points (H W, 2) of all pixels, row by row."""
    v, u = np.mgrid[: camera.height, : camera.width].astype(np.float64)
    return np.column_stack([u.ravel(), v.ravel()])


def backdrop(settings: RenderSettings) -> Backdrop:
    """The look of sky and fog."""
    zenith = ZENITH_RGB if settings.sky else SKY_RGB
    return np.array(SKY_RGB), np.array(zenith), float(-np.log1p(-settings.fog))


def pixel_offsets(side: int) -> Array:
    """(side^2, 2) sample offsets inside a pixel, relative to its centre."""
    steps = (np.arange(side) + 0.5) / side - 0.5
    v, u = np.meshgrid(steps, steps, indexing="ij")
    return np.column_stack([u.ravel(), v.ravel()])
