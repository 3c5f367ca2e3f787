"""Points, cells and triangles drawn without a GPU, with the element that each pixel shows.

A depth buffer: each pixel keeps the nearest element.
"""

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array

NOTHING = -1

# Brightness of the faces of a cell, by axis and side: -x, +x, -y, +y, -z, +z.
_BRIGHTNESS = np.array([0.72, 0.82, 0.55, 1.0, 0.78, 0.9], np.float32)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lens:
    """A camera with square pixels and the principal point at the image centre."""

    T_world_cam: Array
    """(4, 4)"""
    width: int
    height: int
    focal_px: float
    near: float = 1e-3
    """World units; nearer elements are not drawn."""

    @property
    def matrix(self) -> Array:
        """(3, 4) world point -> (u z, v z, z)."""
        R = self.T_world_cam[:3, :3].T
        middle = ((self.width - 1) / 2.0, (self.height - 1) / 2.0)
        K = np.array([[self.focal_px, 0, middle[0]], [0, self.focal_px, middle[1]], [0, 0, 1.0]])
        matrix: Array = K @ np.column_stack([R, -R @ self.T_world_cam[:3, 3]])
        return matrix

    def project(self, points: Array) -> Array:
        """Columns, rows and depths (N, 3) of world points (N, 3)."""
        scaled = points @ self.matrix[:, :3].T + self.matrix[:, 3]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.column_stack([scaled[:, :2] / scaled[:, 2:], scaled[:, 2]])


class Raster:
    """An image drawn incrementally.

    Parameters
    ----------
    lens : Lens
    background : (red, green, blue)
    """

    def __init__(self, lens: Lens, background: tuple[int, int, int]) -> None:
        shape = lens.height, lens.width
        self.lens = lens
        self.image: NDArray[np.uint8] = np.full((*shape, 3), background, np.uint8)
        self.inverse_depth = np.zeros(shape, np.float32)
        """(H, W) 1 / depth; 0 = nothing."""
        self.number = np.full(shape, NOTHING, np.int32)
        """(H, W) number of the element that a pixel shows; NOTHING = none."""

    @property
    def _buffers(self) -> "Buffers":
        return self.image, self.inverse_depth, self.number

    @property
    def _view(self) -> tuple[Array, Array, float]:
        return self.lens.matrix, self.lens.T_world_cam[:3, 3].copy(), self.lens.near

    def add_points(
        self, points: Array, colours: NDArray[np.uint8], numbers: NDArray[np.int32], side_px: int
    ) -> None:
        """Squares of `side_px` pixels at points (N, 3)."""
        _draw_points(
            np.ascontiguousarray(points, np.float64), colours, numbers, side_px,
            (self.lens.matrix, self.lens.near), self._buffers,
        )  # fmt: skip

    def add_cells(
        self,
        index: NDArray[np.int64],
        covered: NDArray[np.uint8],
        colours: NDArray[np.uint8],
        numbers: NDArray[np.int32],
        cell_size: float,
    ) -> None:
        """Cubes: cells (K, 3) of a map.

        Parameters
        ----------
        covered : (K,) uint8
            Bit f is set if face f (-x, +x, -y, +y, -z, +z) is covered by a neighbour.
        """
        _draw_cells(
            np.ascontiguousarray(index, np.int64), covered, (colours, numbers), cell_size,
            self._view, self._buffers,
        )  # fmt: skip

    def add_triangles(
        self,
        vertices: Array,
        triangles: NDArray[np.int32],
        colours: NDArray[np.uint8],
        numbers: NDArray[np.int32],
    ) -> None:
        """Triangles (T, 3) between vertices (V, 3) with colours (V, 3), lit from the camera."""
        _draw_triangles(
            np.ascontiguousarray(vertices, np.float64), np.ascontiguousarray(triangles),
            (colours, numbers), self._view, self._buffers,
        )  # fmt: skip

    def shade(self, strength: float = 60.0) -> None:
        """Darken what lies behind its neighbours (eye-dome lighting).

        Boucheny, Visualisation scientifique de grands volumes de donnees, 2009.
        """
        log_depth = -np.log2(np.maximum(self.inverse_depth, np.float32(1e-12)))
        hollow = np.zeros(log_depth.shape, np.float32)
        for axis in (0, 1):
            step = np.diff(log_depth, axis=axis)
            step = np.clip(step, -0.05, 0.05)
            ahead = [slice(None)] * 2
            behind = [slice(None)] * 2
            ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
            hollow[tuple(ahead)] += np.maximum(step, 0.0)
            hollow[tuple(behind)] += np.maximum(-step, 0.0)
        light = np.where(self.number == NOTHING, 1.0, np.exp2(-strength / 2.0 * hollow))
        np.multiply(self.image, light[..., None], out=self.image, casting="unsafe")


Buffers = tuple[NDArray[np.uint8], NDArray[np.float32], NDArray[np.int32]]
"""Image (H, W, 3), inverse depth (H, W) and number (H, W)."""
Colours = NDArray[np.uint8]
Numbers = NDArray[np.int32]


@numba.njit(cache=True)
def _project(matrix: Array, point: Array, near: float, at: Array) -> bool:
    """Put (u, v, 1 / depth) of a point into `at`; return whether it is in front of the camera."""
    depth = matrix[2, 0] * point[0] + matrix[2, 1] * point[1] + matrix[2, 2] * point[2]
    depth += matrix[2, 3]
    if not depth > near:
        return False
    for axis in range(2):
        scaled = matrix[axis, 0] * point[0] + matrix[axis, 1] * point[1]
        at[axis] = (scaled + matrix[axis, 2] * point[2] + matrix[axis, 3]) / depth
    at[2] = 1.0 / depth
    return True


@numba.njit(cache=True)
def _paint(
    y: int, x: int, nearness: float, look: tuple[Colours, float, int], buffers: Buffers
) -> None:
    """Draw one pixel unless something nearer is there."""
    image, inverse, shown = buffers
    if nearness <= inverse[y, x]:
        return
    colour, light, number = look
    inverse[y, x] = nearness
    shown[y, x] = number
    for channel in range(3):
        image[y, x, channel] = np.uint8(colour[channel] * light)


@numba.njit(cache=True)
def _draw_points(
    points: Array, colours: Colours, numbers: Numbers, side: int, view: tuple[Array, float],
    buffers: Buffers,
) -> None:  # fmt: skip
    height, width = buffers[1].shape
    at = np.empty(3)
    for row in range(len(points)):
        if not _project(view[0], points[row], view[1], at):
            continue
        left = int(np.floor(at[0] - 0.5 * side + 1.0))
        top = int(np.floor(at[1] - 0.5 * side + 1.0))
        look = (colours[row], 1.0, numbers[row])
        for y in range(max(top, 0), min(top + side, height)):
            for x in range(max(left, 0), min(left + side, width)):
                _paint(y, x, at[2], look, buffers)


@numba.njit(cache=True)
def _draw_cells(
    index: NDArray[np.int64],
    covered: NDArray[np.uint8],
    looks: tuple[Colours, Numbers],
    cell: float,
    view: tuple[Array, Array, float],
    buffers: Buffers,
) -> None:
    eye = view[1]
    at = np.empty((4, 3))
    for row in range(len(index)):
        for face in range(6):
            axis, side = face // 2, face % 2
            plane = (index[row, axis] + side) * cell
            # Only uncovered faces that face the camera.
            if covered[row] >> face & 1 or (eye[axis] - plane) * (2 * side - 1) <= 0:
                continue
            if _project_face(index[row], cell, face, view, at):
                look = (looks[0][row], _BRIGHTNESS[face], looks[1][row])
                _fill(at[0], at[1], at[2], look, buffers)
                _fill(at[0], at[2], at[3], look, buffers)


@numba.njit(cache=True)
def _project_face(
    index: NDArray[np.int64], cell: float, face: int, view: tuple[Array, Array, float], at: Array
) -> bool:
    """Put the corners (4, 3) of a face into `at`; return whether all are in front of the camera."""
    axis = face // 2
    first, second = (axis + 1) % 3, (axis + 2) % 3
    place = np.empty(3)
    place[axis] = (index[axis] + face % 2) * cell
    for corner in range(4):
        place[first] = (index[first] + (corner == 1 or corner == 2)) * cell
        place[second] = (index[second] + (corner >= 2)) * cell
        if not _project(view[0], place, view[2], at[corner]):
            return False
    return True


@numba.njit(cache=True)
def _draw_triangles(
    vertices: Array,
    triangles: NDArray[np.int32],
    looks: tuple[Colours, Numbers],
    view: tuple[Array, Array, float],
    buffers: Buffers,
) -> None:
    at = np.empty((3, 3))
    mean = np.empty(3, np.uint8)
    for row in range(len(triangles)):
        first, second, third = triangles[row]
        is_before = _project(view[0], vertices[first], view[2], at[0])
        is_before = is_before and _project(view[0], vertices[second], view[2], at[1])
        is_before = is_before and _project(view[0], vertices[third], view[2], at[2])
        if not is_before:
            continue
        light = _light(vertices[first], vertices[second], vertices[third], view[1])
        for channel in range(3):
            total = np.int64(looks[0][first, channel]) + looks[0][second, channel]
            mean[channel] = (total + looks[0][third, channel]) // 3
        _fill(at[0], at[1], at[2], (mean, light, looks[1][row]), buffers)


@numba.njit(cache=True)
def _light(a: Array, b: Array, c: Array, eye: Array) -> float:
    """Brightness, 0.45 to 1: higher the more a triangle faces the camera, from either side."""
    normal = np.cross(b - a, c - a)
    towards = eye - a
    length = np.sqrt((normal * normal).sum() * (towards * towards).sum())
    if length == 0.0:
        return 1.0
    return float(0.45 + 0.55 * abs((normal * towards).sum()) / length)


@numba.njit(cache=True)
def _fill(a: Array, b: Array, c: Array, look: tuple[Colours, float, int], buffers: Buffers) -> None:
    """Fill a triangle of (u, v, 1 / depth) corners; 1 / depth is linear over the image."""
    height, width = buffers[1].shape
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if area == 0.0:
        return
    top = max(int(np.ceil(min(a[1], b[1], c[1]))), 0)
    bottom = min(int(np.floor(max(a[1], b[1], c[1]))), height - 1)
    left = max(int(np.ceil(min(a[0], b[0], c[0]))), 0)
    right = min(int(np.floor(max(a[0], b[0], c[0]))), width - 1)
    for y in range(top, bottom + 1):
        for x in range(left, right + 1):
            share_c = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
            share_b = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
            share_a = 1.0 - share_b - share_c
            if min(share_a, share_b, share_c) >= 0.0:
                _paint(y, x, share_a * a[2] + share_b * b[2] + share_c * c[2], look, buffers)
