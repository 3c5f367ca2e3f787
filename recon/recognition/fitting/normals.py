"""Surface normals from the neighbours of each point."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.recognition.fitting.least_axis import Moments, least_axis

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

NUM_NEIGHBOURS = 12
"""Enough to average out noise, few enough to stay on one face."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Neighbourhoods:
    """The nearest neighbours of each point."""

    normals: Array
    """(N, 3) unit directions in which they vary least, away from the middle of the points."""
    thickness: Array
    """(N,) their standard deviation along the normal."""
    spacing: Array
    """(N,) distance to the nearest."""


def estimate_normals(points: Array) -> Array:
    """Unit normals (N, 3), pointing away from the middle of the points."""
    return neighbourhoods(points).normals


def neighbourhoods(points: Array) -> Neighbourhoods:
    """The neighbourhoods of points (N, 3)."""
    count = min(NUM_NEIGHBOURS, len(points))
    away, near = map(np.asarray, cKDTree(points).query(points, k=np.arange(1, count + 1)))
    normals, variances = _principal_normals(np.ascontiguousarray(points), near)
    outward = np.einsum("ij,ij->i", normals, points - points.mean(axis=0))
    return Neighbourhoods(
        normals=np.where(outward < 0, -1.0, 1.0)[:, None] * normals,
        thickness=np.sqrt(variances),
        spacing=away[:, min(1, count - 1)],
    )


@njit(cache=True)
def _principal_normals(points: Array, near: Numbers) -> tuple[Array, Array]:
    """The direction in which the neighbours of each point vary least.

    Parameters
    ----------
    points : (N, 3)
    near : (N, K)
        Rows of the neighbours of each point.

    Returns
    -------
    normals : (N, 3)
    variances : (N,)
        Of the neighbours along them.
    """
    normals, variances = np.empty(points.shape), np.empty(len(points))
    for i in range(len(points)):
        moments = _moments(points, points[i], near[i])
        xx, xy, xz, yy, yz, zz = moments
        x, y, z = least_axis(moments)
        normals[i, 0], normals[i, 1], normals[i, 2] = x, y, z
        along = x * (xx * x + 2.0 * (xy * y + xz * z)) + y * (yy * y + 2.0 * yz * z) + zz * z * z
        variances[i] = max(along, 0.0)
    return normals, variances


@njit(cache=True)
def _moments(points: Array, origin: Array, near: Numbers) -> Moments:
    """Covariance of some points (N, 3), from their offsets from an origin among them."""
    share = 1.0 / len(near)
    sx, sy, sz = 0.0, 0.0, 0.0
    xx, xy, xz, yy, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for row in near:
        x, y, z = points[row, 0] - origin[0], points[row, 1] - origin[1], points[row, 2] - origin[2]
        sx, sy, sz = sx + x, sy + y, sz + z
        xx, xy, xz = xx + x * x, xy + x * y, xz + x * z
        yy, yz, zz = yy + y * y, yz + y * z, zz + z * z
    mx, my, mz = sx * share, sy * share, sz * share
    return (
        xx * share - mx * mx,
        xy * share - mx * my,
        xz * share - mx * mz,
        yy * share - my * my,
        yz * share - my * mz,
        zz * share - mz * mz,
    )
