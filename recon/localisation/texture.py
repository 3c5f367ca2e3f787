"""Texture: the colours of a map's surfaces in full detail, as the pairs of its run show them.

Round things have the same shape from all sides; their texture tells the sides apart, and the sides
of one house from those of another. The solids of the objects say where each piece of surface is.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter

from recon.camera import StereoRig
from recon.geometry import Array
from recon.localisation.registration import Points
from recon.localisation.texels import TILE_PX, Camera, in_view
from recon.recognition.fitting.surface_points import area, surface
from recon.records import FoundObject, Plane, StereoPair

PER_CELL = 6.0
"""Texels per area of a cell's face."""
REACH_CELLS, HIDDEN_CELLS = 0.5, 1.5
"""Texels hide what is so far behind them within so far around them."""
SMOOTH_CELLS = 3.0
"""Texture is what differs from the mean of blocks of this side."""
FINE_PX = 3.0
"""Least width of a cell, foreshortened, in images that show its texture; in others its colours are
mixed with those around it."""
LIKENESS = 0.5
"""Correlation of the same texture seen twice."""
SHARED = 2.0
"""Neighbouring cells share the errors of their surface: so many count as one."""
COLOUR_SIGMA, MOST_SIGMAS_SQ = 20.0, 9.0
"""Standard deviation of a block's mean colour, and square from which on it does not agree."""
BLOCKS_PER_E = 5.0
"""Number of blocks, one standard deviation squared off, that make a pose e times less likely."""
BEHIND, NUM_SIGMAS = 1.25, 2.0
"""A point hides what is farther by this factor, and by so many of its standard deviations."""
NUM_SIDES, SIDE_SHARE = 12, 0.3
"""Sides of a thing, and the least share of the texels of one side that another one has."""
MIN_TEXELS = 20
"""Fewer texels in view say nothing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Screen:
    """The nearest points of a pair, tile by tile: what the map does not have may hide it."""

    depth: Array
    """(R, C) greatest likely depth of the nearest point in and around each tile."""

    @classmethod
    def of(cls, points: Points, rig: StereoRig) -> "Screen":
        """The screen of a pair's points."""
        depth = np.full((math.ceil(rig.height / TILE_PX), math.ceil(rig.width / TILE_PX)), np.inf)
        tile = np.floor((rig.project_left(points.points_left) + 0.5) / TILE_PX).astype(np.intp)
        inside = ((tile >= 0) & (tile < depth.shape[::-1])).all(axis=1)
        column, row = tile[inside].T
        farthest = points.points_left[inside, 2] + NUM_SIGMAS * points.sigma[inside]
        np.minimum.at(depth, (row, column), farthest)
        return cls(depth=minimum_filter(depth, 3))

    def hides(self, points_px: Array, depth: Array) -> NDArray[np.bool_]:
        """True for points (N, 2) at depths (N,) that are behind it."""
        column, row = np.floor((points_px + 0.5) / TILE_PX).astype(np.intp).T
        last = np.array(self.depth.shape) - 1
        hidden: NDArray[np.bool_] = (
            depth > BEHIND * self.depth[np.clip(row, 0, last[0]), np.clip(column, 0, last[1])]
        )
        return hidden


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Texture:
    """Small pieces of surface with their colours."""

    points: Array
    """(K, 3) world."""
    normals: Array
    """(K, 3) outwards."""
    colours: Array
    """(K, 3) RGB."""
    usual: Array
    """(K, 3) mean colours all around their objects at the same height and distance from the middle.
    """
    zoom: Array
    """(K,) pixels per length in the image that shows it best, foreshortened."""
    pair: NDArray[np.intp]
    """(K,) number of the pair that shows it best."""
    thing: NDArray[np.intp]
    """(K,) number of its object."""
    cell: NDArray[np.intp]
    """(K,) number of its cell."""
    block: NDArray[np.intp]
    """(K,) number of its block of cells."""
    is_whole: NDArray[np.bool_]
    """(T,) True for things whose texture is known all round."""
    cell_size: float

    def __len__(self) -> int:
        return len(self.points)

    @classmethod
    def of(
        cls, objects: Sequence[FoundObject], pairs: Sequence[StereoPair], cell_size: float
    ) -> "Texture":
        """The texture of objects, each piece from the pair that shows it best."""
        points, normals, thing = _drawn(objects, cell_size)
        zoom, pair = np.zeros(len(points)), np.full(len(points), -1, np.intp)
        colours = np.zeros((len(points), 3))
        for number, one in enumerate(pairs):
            assert one.T_world_left is not None
            camera = camera_of(one.T_world_left, one.rig)
            rows, seen = _in_view(points, normals, camera, cell_size)
            here = seen[:, 2] * seen[:, 3]
            better = here > zoom[rows]
            rows = rows[better]
            zoom[rows], pair[rows] = here[better], number
            colours[rows] = looked_up(one.left, seen[better, :2])
        kept = zoom * cell_size > FINE_PX
        points, colours, thing = points[kept], colours[kept], thing[kept]
        ring = _rings(points, thing, cell_size)
        return cls(
            points=points,
            normals=normals[kept],
            colours=colours,
            usual=_means(colours, ring)[ring],
            zoom=zoom[kept],
            pair=pair[kept],
            thing=thing,
            cell=_numbered(points, cell_size),
            block=_numbered(points, SMOOTH_CELLS * cell_size),
            is_whole=_are_whole(points, thing, len(objects)),
            cell_size=cell_size,
        )

    def seen_from(self, T_world_left: Array, rig: StereoRig) -> tuple[NDArray[np.int64], Array]:
        """Rows (M,) in view, and u, v, pixels per length and cosine (M, 4)."""
        return _in_view(self.points, self.normals, camera_of(T_world_left, rig), self.cell_size)

    def evidence(self, pair: StereoPair, screen: Screen, T_world_left: Array) -> float:
        """Log likelihood ratio of what a pair shows, if taken there, against other textures."""
        rows, colours = self._shown(pair, screen, T_world_left)
        if len(rows) < MIN_TEXELS:
            return 0.0
        return self._alike(rows, colours) - self._off(rows, colours)

    def fit(self, pair: StereoPair, screen: Screen, T_world_left: Array) -> float:
        """Agreement of usual colours, at most 0: of outlines and parts, whatever side is ahead."""
        rows, colours = self._shown(pair, screen, T_world_left)
        if len(rows) < MIN_TEXELS:
            return -MOST_SIGMAS_SQ
        off_sq = ((colours - self.usual[rows]) ** 2).mean(axis=1) / COLOUR_SIGMA**2
        return -float(np.minimum(off_sq, MOST_SIGMAS_SQ).mean())

    def _shown(
        self, pair: StereoPair, screen: Screen, T_world_left: Array
    ) -> tuple[NDArray[np.int64], Array]:
        """Rows (M,) of the texels that a pair should show, and what it shows there (M, 3)."""
        rows, seen = self.seen_from(T_world_left, pair.rig)
        is_clear = seen[:, 2] * seen[:, 3] * self.cell_size > FINE_PX
        is_clear &= ~screen.hides(seen[:, :2], pair.rig.focal_px / seen[:, 2])
        return rows[is_clear], looked_up(pair.left, seen[is_clear, :2])

    def likeness(self, pair: StereoPair, screen: Screen, T_world_left: Array) -> float:
        """Correlation of the texture that a pair shows, if taken there, with the known one."""
        rows, colours = self._shown(pair, screen, T_world_left)
        return self._likeness(rows, colours) if len(rows) >= MIN_TEXELS else 0.0

    def _likeness(self, rows: NDArray[np.intp], colours: Array) -> float:
        block = self.block[rows]
        own, known = (_beyond_mean(of.mean(axis=1), block) for of in (colours, self.colours[rows]))
        size = np.sqrt((own @ own) * (known @ known))
        return float(own @ known / size) if size > 0.0 else 0.0

    def _alike(self, rows: NDArray[np.intp], colours: Array) -> float:
        """Log likelihood ratio of the texture."""
        number = np.count_nonzero(np.bincount(self.cell[rows])) / SHARED
        # Ratio of two normal distributions, of correlation LIKENESS and 0.
        rest = 1.0 - LIKENESS**2
        gain = (LIKENESS * self._likeness(rows, colours) - LIKENESS**2) / rest
        return float(number * (gain - 0.5 * np.log(rest)))

    def _off(self, rows: NDArray[np.intp], colours: Array) -> float:
        """Log likelihood that is lost as colours differ."""
        off = _means(colours - self.colours[rows], self.block[rows])
        off_sq = (off**2).mean(axis=1) / COLOUR_SIGMA**2
        return float(np.minimum(off_sq, MOST_SIGMAS_SQ).sum() / (2.0 * BLOCKS_PER_E))


def camera_of(T_world_left: Array, rig: StereoRig) -> Camera:
    """The left camera of a rig at a pose."""
    return Camera(
        turn=np.ascontiguousarray(T_world_left[:3, :3]),
        eye=np.ascontiguousarray(T_world_left[:3, 3]),
        focal_px=rig.focal_px, cx_px=rig.cx_left_px, cy_px=rig.cy_px,
        width=rig.width, height=rig.height,
    )  # fmt: skip


def _in_view(
    points: Array, normals: Array, camera: Camera, cell_size: float
) -> tuple[NDArray[np.int64], Array]:
    reach, slack = REACH_CELLS * cell_size, HIDDEN_CELLS * cell_size
    found: tuple[NDArray[np.int64], Array] = in_view(points, normals, camera, reach, slack)
    return found


def looked_up(image: NDArray[np.uint8], points_px: Array) -> Array:
    """Colours (N, 3) of an image at points (N, 2)."""
    if not len(points_px):
        return np.zeros((0, 3))
    u, v = points_px.astype(np.float32).T[:, None]
    found = cv2.remap(image, u, v, cv2.INTER_LINEAR)[0].astype(np.float64)
    return found if found.ndim == 2 else np.repeat(found[:, None], 3, axis=1)


def _drawn(
    objects: Sequence[FoundObject], cell_size: float
) -> tuple[Array, Array, NDArray[np.intp]]:
    """Points and outward normals (K, 3) on the solids of objects, and the objects' numbers."""
    points, normals, thing = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros(0, np.intp)]
    for number, one in enumerate(objects):
        solids = [part.solid for part in one.parts if not isinstance(part.solid, Plane)]
        if not solids:
            continue
        whole = sum(area(solid) for solid in solids)
        count = int(PER_CELL * whole / cell_size**2) + len(solids)
        drawn = surface(solids, count, np.random.default_rng(0))
        points.append(drawn.points)
        normals.append(drawn.normals)
        thing.append(np.full(len(drawn.points), number, np.intp))
    return np.concatenate(points), np.concatenate(normals), np.concatenate(thing)


def _numbered(points: Array, side: float) -> NDArray[np.intp]:
    """Number (K,) of the cube of a grid that each point is in."""
    cubes = np.floor(points / side).astype(np.int64)
    return np.unique(cubes, axis=0, return_inverse=True)[1].ravel().astype(np.intp)


def _are_whole(points: Array, thing: NDArray[np.intp], number: int) -> NDArray[np.bool_]:
    """(T,) True for things of which no side has far fewer points than another."""
    out = points[:, [0, 2]] - _middles(points, thing)[thing]
    turn = (np.arctan2(out[:, 1], out[:, 0]) / (2.0 * np.pi)) % 1.0
    side = thing * NUM_SIDES + np.minimum((turn * NUM_SIDES).astype(np.intp), NUM_SIDES - 1)
    on = np.bincount(side, minlength=number * NUM_SIDES).reshape(number, NUM_SIDES)
    return np.asarray(on.min(axis=1) > SIDE_SHARE * on.max(axis=1), np.bool_)


def _middles(points: Array, thing: NDArray[np.intp]) -> Array:
    """Middles (T, 2) of things in x, z."""
    return _means(points[:, [0, 2]], thing)


def _rings(points: Array, thing: NDArray[np.intp], cell_size: float) -> NDArray[np.intp]:
    """Number (K,) of the ring around its thing that each point is on."""
    away = np.hypot(*(points[:, [0, 2]] - _middles(points, thing)[thing]).T)
    return _numbered(np.column_stack([thing * cell_size, points[:, 1], away]), cell_size)


def _means(values: Array, group: NDArray[np.intp]) -> Array:
    """Mean (G, C) of the values (N, C) of each group; 0 without values."""
    number = np.maximum(np.bincount(group), 1)
    return np.stack([np.bincount(group, of) / number for of in values.T], axis=1)


def _beyond_mean(values: Array, block: NDArray[np.intp]) -> Array:
    """Values (N,) less the means of their blocks."""
    number = np.maximum(np.bincount(block), 1)
    beyond: Array = values - (np.bincount(block, values) / number)[block]
    return beyond
