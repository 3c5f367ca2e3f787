"""Surfaces: dense disparity maps and triangle meshes."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError, check_finite, check_shape
from recon.geometry import transform

_CHUNK = 1 << 17
"""Triangles processed at once; their corners take several times their own memory."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DisparityMap:
    """Disparity of every left pixel of a rectified pair, with its uncertainty."""

    disparity_px: NDArray[np.float32]
    """(H, W) u_left - u_right; NaN = unknown."""
    sigma_px: NDArray[np.float32]
    """(H, W) standard deviation of the disparity, > 0; NaN exactly where the disparity is."""

    def __post_init__(self) -> None:
        check_shape("disparity_px", self.disparity_px, (None, None))
        check_shape("sigma_px", self.sigma_px, self.disparity_px.shape)
        if not np.array_equal(np.isnan(self.disparity_px), np.isnan(self.sigma_px)):
            raise InputError("sigma_px is not NaN exactly where disparity_px is, but has to be")

    def __repr__(self) -> str:
        height, width = self.disparity_px.shape
        return f"DisparityMap({width} x {height} pixels, {self.coverage:.0%} known)"

    @property
    def valid_mask(self) -> NDArray[np.bool_]:
        """(H, W) pixels whose disparity is known."""
        return np.isfinite(self.disparity_px)

    @property
    def coverage(self) -> float:
        """Share of the pixels whose disparity is known."""
        return float(self.valid_mask.mean())

    def where(self, kept_mask: NDArray[np.bool_]) -> "DisparityMap":
        """The same disparities, unknown outside `kept_mask` (H, W)."""
        nothing = np.float32(np.nan)
        return DisparityMap(
            disparity_px=np.where(kept_mask, self.disparity_px, nothing),
            sigma_px=np.where(kept_mask, self.sigma_px, nothing),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mesh:
    """A triangulated surface; the owner defines the frame, for a run the world."""

    vertices: NDArray[np.float64]
    """(V, 3) world units."""
    triangles: NDArray[np.int32]
    """(T, 3) rows of `vertices`, counter-clockwise seen from outside."""
    colours: NDArray[np.uint8] | None = None
    """(V, 3) RGB; None if unknown."""
    normals: NDArray[np.float64] | None = None
    """(V, 3) unit vectors that point outwards; None if unknown."""
    attributes: Mapping[str, NDArray[np.generic]] = field(default_factory=dict)
    """(V,) further values per vertex, by name."""

    def __post_init__(self) -> None:
        check_shape("vertices", self.vertices, (None, 3))
        check_finite("vertices", self.vertices)
        check_shape("triangles", self.triangles, (None, 3))
        num_vertices = len(self.vertices)
        if self.triangles.dtype.kind not in "iu":
            raise InputError(f"triangles are {self.triangles.dtype}, but integers are needed")
        if self.triangles.size:
            lowest, highest = int(self.triangles.min()), int(self.triangles.max())
            if lowest < 0 or highest >= num_vertices:
                raise InputError(
                    f"triangles use the vertices {lowest} to {highest}, "
                    f"but there are {num_vertices}"
                )
        if self.colours is not None:
            check_shape("colours", self.colours, (num_vertices, 3))
            if self.colours.dtype != np.uint8:
                raise InputError(f"colours are {self.colours.dtype}, but uint8 is needed")
        if self.normals is not None:
            check_shape("normals", self.normals, (num_vertices, 3))
        for name, values in self.attributes.items():
            check_shape(name, values, (num_vertices,))

    def __len__(self) -> int:
        return len(self.triangles)

    @classmethod
    def none(cls) -> "Mesh":
        """A mesh without triangles."""
        nothing = np.zeros((0, 3))
        return cls(
            vertices=nothing, triangles=nothing.astype(np.int32),
            colours=nothing.astype(np.uint8), normals=nothing,
        )  # fmt: skip

    @property
    def corners(self) -> NDArray[np.float64]:
        """(T, 3, 3) corners of each triangle."""
        return self.vertices[self.triangles]

    @property
    def crosses(self) -> NDArray[np.float64]:
        """(T, 3) normal of each triangle, whose length is twice the area."""
        crosses = np.empty((len(self), 3))
        for first in range(0, len(self), _CHUNK):
            some = slice(first, first + _CHUNK)
            a, b, c = np.moveaxis(self.vertices[self.triangles[some]], 1, 0)
            crosses[some] = np.cross(b - a, c - a)
        return crosses

    @property
    def triangle_areas(self) -> NDArray[np.float64]:
        """(T,) square world units."""
        areas: NDArray[np.float64] = np.linalg.norm(self.crosses, axis=1) / 2
        return areas

    @property
    def area(self) -> float:
        """Square world units."""
        return float(self.triangle_areas.sum())

    def transformed(self, T_target_source: ArrayLike) -> "Mesh":
        """The same surface in the target frame."""
        T = np.asarray(T_target_source, dtype=np.float64)
        return replace(
            self,
            vertices=transform(T, self.vertices),
            normals=None if self.normals is None else self.normals @ T[:3, :3].T,
        )

    def select(self, rows: NDArray[np.integer] | NDArray[np.bool_]) -> "Mesh":
        """The triangles of `rows`, with the vertices they use, in their original order."""
        triangles = self.triangles[rows]
        used, renumbered = np.unique(triangles, return_inverse=True)
        return Mesh(
            vertices=self.vertices[used],
            triangles=renumbered.reshape(-1, 3).astype(np.int32),
            colours=None if self.colours is None else self.colours[used],
            normals=None if self.normals is None else self.normals[used],
            attributes={name: values[used] for name, values in self.attributes.items()},
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshPart:
    """One of the parts of a mesh too large for memory."""

    vertices: NDArray[np.float64]
    """(V, 3) world units."""
    normals: NDArray[np.float64]
    """(V, 3) unit vectors that point outwards."""
    colours: NDArray[np.uint8]
    """(V, 3) RGB."""
    triangles: NDArray[np.int32]
    """(T, 3) rows of the vertices of all parts up to this one."""
