"""Texture: the grey levels of a map's surfaces, as its pairs saw them, compared with an image.

Round objects have the same shape from all sides; only their texture shows from which side they are
seen. Grey levels are compared patch by patch with their means subtracted, so that neither shading
nor exposure counts.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.geometry import invert, transform
from recon.localisation.surfels import Surfels
from recon.recognition.cells import distinct
from recon.records import PointCloud

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

TEXEL_CELLS, PATCH_CELLS = 0.5, 2.0
"""Sides of the pieces of surface that have one grey level, and of the patches that are compared."""
MAX_SIGMA_CELLS = 1.5
"""Points with a larger sigma are ignored."""
REACH_CELLS = 1.5
"""Distance from the surface up to which points belong to it."""
SNAP_CELLS, SNAP_SIGMAS = 0.3, 2.0
"""Most that a point is moved along its ray to the surface."""
LEAST_COSINE = 0.3
"""Surfaces seen more obliquely are not compared."""
MIN_TEXELS, MIN_CONTRAST = 5, 3.0
"""Texels of a patch, and standard deviation of its grey levels, that are needed."""
CORRELATION = 0.3
"""Typical correlation of a patch with the image at the true pose."""
PER_TEXEL = 0.5
"""Number of independent values per texel; neighbours are correlated."""
DEPTH_PX = 8
"""Side of the blocks in which the nearest surface hides others, pixels."""
HIDDEN_CELLS = 2.5
MIN_DEPTH_CELLS = 0.5
LUMINANCE = np.array([0.299, 0.587, 0.114])
NUM_TILES = 8
"""Tiles along each side of an image by which two poses are compared."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Likeness:
    """The evidence of texture for one pose, by tile of the image."""

    evidence: Array
    """(NUM_TILES**2,) log likelihood ratio of each tile against any other texture."""
    is_covered: NDArray[np.bool_]
    """(NUM_TILES**2,) True where the map has texture."""

    @property
    def total(self) -> float:
        """Log likelihood ratio of the whole image."""
        return float(self.evidence.sum())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Texture:
    """Pieces of surface with their grey levels."""

    points: Array
    """(K, 3) world."""
    normals: Array
    """(K, 3) unit, outwards."""
    grey: Array
    """(K,)"""
    patch: Indices
    """(K,) number of the patch."""
    surface: Array
    """(S, 3) world points of all surfaces, which hide what is behind them."""
    cell_size: float

    @classmethod
    def of(cls, views: Iterable[tuple[PointCloud, Array]], surfels: Surfels) -> "Texture | None":
        """The texture of the points of a map; None if no point has a colour.

        Parameters
        ----------
        views : iterable of (PointCloud, (3,) array)
            World points with colours and sigma, by the position of the camera that saw them.
        surfels : Surfels
            The surfaces of the map.
        """
        parts = [
            _on_surface(cloud, seen_from, surfels)
            for cloud, seen_from in views
            if cloud.colours is not None and cloud.sigma is not None
        ]
        values = np.concatenate([np.zeros((0, 8)), *parts])
        return cls._mean(values[:, :7], values[:, 7], surfels) if len(values) else None

    @classmethod
    def _mean(cls, values: Array, weight: Array, surfels: Surfels) -> "Texture":
        """The texels of points with their normals and grey levels (N, 7)."""
        side = TEXEL_CELLS * surfels.cell_size
        texel = distinct(np.floor(values[:, :3] / side).astype(np.int64))[1]
        total = np.bincount(texel, weight)
        mean = np.column_stack([np.bincount(texel, weight * one) / total for one in values.T])
        normals = mean[:, 3:6]
        normals = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-9)[:, None]
        patch = np.floor(mean[:, :3] / (PATCH_CELLS * surfels.cell_size)).astype(np.int64)
        return cls(
            points=mean[:, :3], normals=normals, grey=mean[:, 6],
            patch=np.asarray(distinct(patch)[1], np.intp), surface=surfels.means,
            cell_size=surfels.cell_size,
        )  # fmt: skip

    def likeness(self, image: NDArray[np.float32], rig: StereoRig, T_world_left: Array) -> Likeness:
        """The evidence of the grey levels of a left image (H, W) float32 for a pose."""
        rows, pixels = self._visible(rig, T_world_left)
        if not len(rows):
            return Likeness(
                evidence=np.zeros(NUM_TILES**2), is_covered=np.zeros(NUM_TILES**2, bool)
            )
        seen = cv2.remap(
            image, pixels[:, 0].astype(np.float32), pixels[:, 1].astype(np.float32),
            cv2.INTER_LINEAR,
        ).ravel()  # fmt: skip
        _, patch = np.unique(self.patch[rows], return_inverse=True)
        return _compared(self.grey[rows], seen.astype(np.float64), patch, pixels / rig_size(rig))

    def _visible(self, rig: StereoRig, T_world_left: Array) -> tuple[Indices, Array]:
        """Rows and pixels (V, 2) of the texels that a camera sees."""
        offset = T_world_left[:3, 3] - self.points
        cosine = np.einsum("ni,ni->n", self.normals, offset) / np.linalg.norm(offset, axis=1)
        rows, pixels, depth = _projected(self.points, rig, T_world_left, self.cell_size)
        facing = cosine[rows] > LEAST_COSINE
        rows, pixels, depth = rows[facing], pixels[facing], depth[facing]
        hides = self._nearest(rig, T_world_left)
        block = (pixels / DEPTH_PX).astype(np.intp)
        shown = depth < hides[block[:, 1], block[:, 0]] + HIDDEN_CELLS * self.cell_size
        return rows[shown], pixels[shown]

    def _nearest(self, rig: StereoRig, T_world_left: Array) -> Array:
        """Depth of the nearest surface in each block of the image."""
        nearest = np.full((rig.height // DEPTH_PX + 1, rig.width // DEPTH_PX + 1), np.inf)
        _, pixels, depth = _projected(self.surface, rig, T_world_left, self.cell_size)
        block = (pixels / DEPTH_PX).astype(np.intp)
        np.minimum.at(nearest, (block[:, 1], block[:, 0]), depth)
        return nearest


def _on_surface(cloud: PointCloud, seen_from: Array, surfels: Surfels) -> Array:
    """Points, normals, grey levels and weights (N, 8) of a view, moved onto the surface."""
    cell = surfels.cell_size
    assert cloud.colours is not None
    assert cloud.sigma is not None
    precise = np.flatnonzero(cloud.sigma <= MAX_SIGMA_CELLS * cell)
    rows, surfel = surfels.near(cloud.points[precise], REACH_CELLS * cell)
    rows = precise[rows]
    ray = cloud.points[rows] - seen_from
    away = np.maximum(np.linalg.norm(ray, axis=1), 1e-9)
    ray = ray / away[:, None]
    normals = surfels.normals[surfel]
    cosine = -np.einsum("ni,ni->n", normals, ray)
    normals, cosine = normals * np.where(cosine < 0.0, -1.0, 1.0)[:, None], np.abs(cosine)
    gap = np.einsum("ni,ni->n", normals, surfels.means[surfel] - cloud.points[rows])
    most = SNAP_SIGMAS * cloud.sigma[rows] + SNAP_CELLS * cell
    along = np.clip(-gap / np.maximum(cosine, LEAST_COSINE), -most, most)
    points = cloud.points[rows] + along[:, None] * ray
    grey = cloud.colours[rows] @ LUMINANCE
    # The nearer and the more from the front, the sharper.
    values = np.column_stack([points, normals, grey, cosine / away])
    kept: Array = values[cosine > LEAST_COSINE]
    return kept


def rig_size(rig: StereoRig) -> Array:
    """Width and height of an image, pixels."""
    return np.array([rig.width, rig.height], np.float64)


def _projected(
    points: Array, rig: StereoRig, T_world_left: Array, cell_size: float
) -> tuple[Indices, Array, Array]:
    """Rows, pixels and depths of the points inside the image."""
    left = transform(invert(T_world_left), points)
    rows = np.flatnonzero(left[:, 2] > MIN_DEPTH_CELLS * cell_size)
    pixels = rig.project_left(left[rows])
    inside = ((pixels >= 0) & (pixels <= rig_size(rig) - 1)).all(axis=1)
    return rows[inside], pixels[inside], left[rows[inside], 2]


def _compared(known: Array, seen: Array, patch: Indices, place: Array) -> Likeness:
    """The evidence of texels, patch by patch; their places are shares of width and height."""
    number = np.maximum(np.bincount(patch), 1)
    known = known - (np.bincount(patch, known) / number)[patch]
    seen = seen - (np.bincount(patch, seen) / number)[patch]
    variance = [np.bincount(patch, one**2) / number for one in (known, seen)]
    both = np.bincount(patch, known * seen) / number
    counts = (number >= MIN_TEXELS) & (variance[0] > MIN_CONTRAST**2)
    # A side without contrast does not agree.
    correlation = both / np.sqrt(variance[0] * np.maximum(variance[1], MIN_CONTRAST**2) + 1e-9)
    evidence: Array = np.where(counts, PER_TEXEL * (number - 1) * _log_ratio(correlation), 0.0)
    middle = [np.bincount(patch, one) / number for one in place.T]
    column, row = (np.minimum((NUM_TILES * one).astype(np.intp), NUM_TILES - 1) for one in middle)
    tile = row * NUM_TILES + column
    return Likeness(
        evidence=np.bincount(tile, evidence, NUM_TILES**2).astype(np.float64),
        is_covered=np.bincount(tile, counts, NUM_TILES**2) > 0,
    )


def _log_ratio(correlation: Array) -> Array:
    """Log likelihood ratio per value of the typical correlation over none."""
    rest = 1.0 - CORRELATION**2
    off = 1.0 + CORRELATION**2 - 2.0 * CORRELATION * correlation
    ratio: Array = 0.5 - 0.5 * np.log(rest) - 0.5 * off / rest
    return ratio
