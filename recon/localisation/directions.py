"""Directions: what a pair sees, by azimuth and slope."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from recon.camera import StereoRig
from recon.localisation.silhouettes import Grid, Seen, Views

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

MARGIN = 3
"""Columns and rows around the field of view."""
MOST_OF_ONE = 3
"""Points of one direction that count, the most certain ones."""
SAME_THING = 0.35
"""Logarithm of the ratio of distances up to which points may be on one object."""
WHOLE_SHARE = 0.7
"""Share of a direction inside the field of view from which on it counts as seen."""
PIXEL_STEP = 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Directions:
    """A grid around the field of view of a camera, and what is seen in it."""

    grid: Grid
    seen: Seen

    @classmethod
    def of(
        cls, points_level: Array, sigma: Array, rig: StereoRig, tilt: Array, side: float
    ) -> "Directions":
        """The directions of a pair.

        Parameters
        ----------
        points_level : (N, 3) array
            Points in the level frame, with x straight ahead.
        sigma : (N,) array
        rig : StereoRig
        tilt : (3, 3) array
            Rotation from the left camera to the level frame.
        side : float
            Azimuth, radians, and slope of one direction.
        """
        field = _field(rig, tilt, side)
        grid, num_pixels = _grid(field, side)
        column, row, away = _directions(points_level, grid)
        inside = (column >= 0) & (column < grid.num_columns) & (row >= 0) & (row < grid.num_rows)
        direction = column * grid.num_rows + row
        kept = _most_certain(direction, sigma, np.flatnonzero(inside))
        shown = np.zeros((grid.num_columns, grid.num_rows), np.bool_)
        shown[column[kept], row[kept]] = True
        is_inside = num_pixels > WHOLE_SHARE * num_pixels.max()
        empty = np.argwhere(is_inside & ~maximum_filter(shown, 3))
        weight = _weights(direction[kept], away[kept])
        seen = Seen(
            column=column[kept], row=row[kept], range=away[kept], sigma=sigma[kept],
            weight=weight, empty=empty, pivot=_nearest(points_level[kept], away[kept]),
        )  # fmt: skip
        return cls(grid=grid, seen=seen)


def all_round(parts: list[Directions]) -> tuple[Grid, Views]:
    """Directions of several pitches in one grid that goes all round; columns stay relative."""
    grids = [part.grid for part in parts]
    side = grids[0].side
    lows = [round(grid.lowest / side) for grid in grids]
    tops = [low + grid.num_rows for low, grid in zip(lows, grids, strict=True)]
    whole = Grid(
        side=side, first=0, lowest=min(lows) * side,
        num_columns=round(2.0 * np.pi / side), num_rows=max(tops) - min(lows),
    )  # fmt: skip
    shifts = [
        np.array([grid.first, low - min(lows)]) for grid, low in zip(grids, lows, strict=True)
    ]
    both = [(part.seen, shift) for part, shift in zip(parts, shifts, strict=True)]
    seen = Seen(
        column=np.concatenate([seen.column + shift[0] for seen, shift in both]),
        row=np.concatenate([seen.row + shift[1] for seen, shift in both]),
        range=np.concatenate([seen.range for seen, _ in both]),
        sigma=np.concatenate([seen.sigma for seen, _ in both]),
        weight=np.concatenate([seen.weight for seen, _ in both]),
        empty=np.concatenate([seen.empty + shift for seen, shift in both]),
        pivot=parts[0].seen.pivot,
    )
    points = np.cumsum([0, *(len(part.seen.column) for part in parts)])
    empty = np.cumsum([0, *(len(part.seen.empty) for part in parts)])
    return whole, Views(seen=seen, points=points, empty=empty)


def _directions(points: Array, grid: Grid) -> tuple[Indices, Indices, Array]:
    away = np.maximum(np.hypot(points[:, 0], points[:, 2]), 1e-9)
    azimuth = np.arctan2(points[:, 2], points[:, 0])
    column = np.floor(azimuth / grid.side).astype(np.int64) - grid.first
    row = np.floor((points[:, 1] / away - grid.lowest) / grid.side).astype(np.int64)
    return column, row, away


def _field(rig: StereoRig, tilt: Array, side: float) -> Array:
    """Azimuth and slope (P, 2) of pixels, in columns and rows."""
    u, v = np.meshgrid(np.arange(0, rig.width, PIXEL_STEP), np.arange(0, rig.height, PIXEL_STEP))
    x, y = (u.ravel() - rig.cx_left_px) / rig.focal_px, (v.ravel() - rig.cy_px) / rig.focal_px
    rays = np.column_stack([x, y, np.ones(len(x))]) @ tilt.T
    azimuth, slope = np.arctan2(rays[:, 2], rays[:, 0]), rays[:, 1] / np.hypot(*rays[:, [0, 2]].T)
    return np.column_stack([azimuth, slope]) / side


def _grid(field: Array, side: float) -> tuple[Grid, Array]:
    """The grid around a field of view, and the number of pixels (A, E) in each direction."""
    low = np.floor(field.min(axis=0)).astype(np.int64) - MARGIN
    shape = np.floor(field.max(axis=0)).astype(np.int64) + MARGIN + 1 - low
    number = np.zeros(shape)
    np.add.at(number, tuple((np.floor(field).astype(np.int64) - low).T), 1.0)
    grid = Grid(
        side=side, first=int(low[0]), lowest=float(low[1] * side),
        num_columns=int(shape[0]), num_rows=int(shape[1]),
    )  # fmt: skip
    return grid, number


def _most_certain(direction: Indices, sigma: Array, kept: Indices) -> Indices:
    """Of the kept points, the most certain ones of each direction."""
    order = np.lexsort((sigma[kept], direction[kept]))
    ordered = direction[kept[order]]
    rank = np.arange(len(order)) - np.searchsorted(ordered, ordered)
    chosen: Indices = np.sort(kept[order[rank < MOST_OF_ONE]])
    return chosen


def _weights(direction: Indices, away: Array) -> Array:
    """Weights (N,): points of one object share its errors, so the root of their number counts."""
    _, group, number = np.unique(direction, return_inverse=True, return_counts=True)
    share = 1.0 / number[group.ravel()]
    order = np.argsort(away, kind="stable")
    log = np.log(np.maximum(away[order], 1e-9))
    total = np.append(0.0, np.cumsum(share[order]))
    high, low = np.searchsorted(log, log + SAME_THING), np.searchsorted(log, log - SAME_THING)
    alike = np.empty(len(away))
    alike[order] = total[high] - total[low]
    weights: Array = share / np.sqrt(np.maximum(alike, 1.0))
    return weights


def _nearest(points: Array, away: Array) -> Array:
    """Middle (2,) of what is nearest, ahead and aside."""
    if not len(points):
        return np.array([1.0, 0.0])
    near = away < 1.4 * np.quantile(away, 0.3)
    middle: Array = points[near][:, [0, 2]].mean(axis=0)
    return middle
