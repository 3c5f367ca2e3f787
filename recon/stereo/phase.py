"""Matching by the phase of all scales and orientations, supported by neighbours (Eqs 15 to 18)."""

import numpy as np
from numpy.typing import NDArray

from recon.records import Features, Matches
from recon.settings import MatchingSettings
from recon.stereo.aggregation import Points, Support, aggregate
from recon.stereo.scores import Search, Side
from recon.stereo.support import SIDE_RADIUS

_RIVAL_WEIGHT = 0.3
"""How much confidence an equally good rival disparity costs."""
_DEAD_ZONE = 0.04
"""Difference of the sides' evidence from which on a point is moved off its edge."""

Rows = NDArray[np.int64]


def match(left: Features, right: Features, settings: MatchingSettings) -> Matches:
    """Pairs that choose each other, moved to the side of their edge that has their disparity."""
    height, width = left.grey.shape
    lowest = max(settings.min_disparity, 1 - width)
    count = min(settings.max_disparity, width - 1) - lowest + 1
    search = Search(lowest, count, 0)
    points = _points(left.points_px.astype(np.int64), left.orientation_rad, height)
    support = aggregate(_side(left), _side(right), points, search)
    rows = np.flatnonzero(np.isfinite(support.score))
    rows = rows[_agrees(left, right, points, support, rows, search)]
    return _ranked(right, points, support, rows)


def _points(pixels: Rows, orientation: NDArray[np.float32], height: int) -> Points:
    return Points(
        u=np.ascontiguousarray(pixels[:, 0]),
        v=np.ascontiguousarray(pixels[:, 1]),
        orientation=orientation,
        starts=np.searchsorted(pixels[:, 1], np.arange(height + 1)),
    )


def _side(features: Features, step: int = 1) -> Side:
    """A picture for the loops; seen in a mirror where `step` is -1."""
    return Side(
        np.ascontiguousarray(features.planes[..., ::step]),
        np.ascontiguousarray(features.candidate_mask[:, ::step]),
        np.pad(features.grey[:, ::step], SIDE_RADIUS, mode="edge"),
    )


def _agrees(
    left: Features, right: Features, points: Points, support: Support, rows: Rows, search: Search
) -> NDArray[np.bool_]:
    """Whether the right pixel of each pair chooses the same disparity."""
    height, width = left.grey.shape
    # In a mirror the right picture's points have the same disparities to the left's.
    column = width - 1 - (points.u[rows] - support.disparity[rows])
    wanted, inverse = np.unique(points.v[rows] * width + column, return_inverse=True)
    pixels = np.column_stack([wanted % width, wanted // width])
    mirrored = _points(pixels, np.zeros(len(wanted), np.float32), height)
    back = aggregate(_side(right, -1), _side(left, -1), mirrored, search)
    agrees: NDArray[np.bool_] = back.disparity[inverse] == support.disparity[rows]
    return agrees


def _ranked(right: Features, points: Points, support: Support, rows: Rows) -> Matches:
    """The pairs as matches, most confident first, of those that met at a pixel the first."""
    height, width = right.grey.shape
    confidence = (support.score - _RIVAL_WEIGHT * support.rival)[rows]
    order = np.argsort(-confidence, kind="stable")
    rows, confidence = rows[order], confidence[order]
    pixels = _moved(points, support, rows)
    disparity = support.disparity[rows]
    inside = ((pixels >= 0) & (pixels < (width, height))).all(axis=1)
    inside &= (pixels[:, 0] - disparity >= 0) & (pixels[:, 0] - disparity < width)
    number = np.where(inside, pixels[:, 1] * width + pixels[:, 0], -1)
    first = np.sort(np.unique(number, return_index=True)[1])
    keep = first[inside[first]]
    rows = rows[keep]
    return Matches(
        points_px=pixels[keep].astype(np.float64),
        disparity_px=disparity[keep].astype(np.float64),
        sigma_px=np.full(len(keep), np.sqrt(1 / 12)),
        score=confidence[keep].astype(np.float64),
        index_left=rows.astype(np.int32),
        index_right=_index_at(right, points.u[rows] - disparity[keep], points.v[rows]),
    )


def _moved(points: Points, support: Support, rows: Rows) -> Rows:
    """Pixels (M, 2) one step toward the side of the edge that has the disparity."""
    side = support.side[rows]
    step = np.where(np.abs(side) > _DEAD_ZONE, np.sign(side), 0.0)
    u = points.u[rows] + np.rint(step * np.cos(points.orientation[rows])).astype(np.int64)
    v = points.v[rows] + np.rint(step * np.sin(points.orientation[rows])).astype(np.int64)
    return np.column_stack([u, v])


def _index_at(features: Features, u: Rows, v: Rows) -> NDArray[np.int32]:
    """Rows of the features at some pixels; -1 = there is none."""
    index = np.full(features.grey.shape, -1, np.int32)
    columns, lines = features.points_px.astype(np.int64).T
    index[lines, columns] = np.arange(len(features))
    found: NDArray[np.int32] = index[v, u]
    return found
