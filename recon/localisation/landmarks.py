"""Landmarks: points that several images of a run show, in known places.

Their depth comes from the poses of the run, not from the disparity of a pair: they are known where
the cameras of a pair are too close together for what is far away, or too far apart to be compared.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.localisation.sights import Rows, Sight, matched

NUM_ROUNDS = 3
NUM_NEIGHBOURS = 8
"""Nearest images with which each is compared ..."""
MIN_COSINE = 0.77
"""... if they look in about the same direction."""
MAX_ERROR_PX = 1.5
"""Greatest distance of a feature from where a landmark is, and from its epipolar line."""
SIGMA_PX = 0.35
"""Standard deviation of a feature in each direction."""
MIN_PARALLAX = 0.017
"""Least angle, radians, between two directions to a landmark."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Landmarks:
    """The landmarks among the features of one image."""

    sight: Sight
    rooted: NDArray[np.float32]
    """(L, 128) descriptors."""
    points: Array
    """(L, 3) world."""
    covariance: Array
    """(L, 3, 3)"""

    def __len__(self) -> int:
        return len(self.points)

    @property
    def depth(self) -> float:
        """Median distance from the camera."""
        return float(np.median(np.linalg.norm(self.points - self.sight.eye, axis=1)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Lines:
    """Lines of sight to the features of one image: its own, then those of others, nearest first."""

    row: Rows
    """(M,) of the feature."""
    eye: Array
    """(M, 3)"""
    direction: Array
    """(M, 3)"""
    focal_px: Array
    """(M,)"""

    def information(self, used: Array, number: int) -> tuple[Array, Array]:
        """Sums (N, 3, 3) and (N, 3) whose quotient is the point nearest to the lines of a row."""
        across = np.eye(3) - self.direction[:, :, None] * self.direction[:, None, :]
        across *= used[:, None, None]
        total, moment = np.zeros((number, 3, 3)), np.zeros((number, 3))
        np.add.at(total, self.row, across)
        np.add.at(moment, self.row, np.einsum("nij,nj->ni", across, self.eye))
        return total, moment

    def nearest(self, number: int) -> Array:
        """(M,) 1 for the image's own lines and the nearest other ones from another side, else 0."""
        cosine = np.einsum("ni,ni->n", self.direction, self.direction[self.row])
        aside = np.flatnonzero(cosine < math.cos(MIN_PARALLAX))
        used = (np.arange(len(self.row)) < number).astype(np.float64)
        used[aside[np.unique(self.row[aside], return_index=True)[1]]] = 1.0
        return used

    def error_px(self, points: Array) -> Array:
        """(M,) distance of the features from where points (N, 3) are seen; infinite if behind."""
        offset = points[self.row] - self.eye
        along = np.einsum("ni,ni->n", offset, self.direction)
        aside = np.linalg.norm(offset - along[:, None] * self.direction, axis=1)
        error = np.full(len(along), np.inf)
        np.divide(self.focal_px * aside, along, out=error, where=along > 0.0)
        return error


def landmarks_of(sights: Sequence[Sight]) -> list[Landmarks]:
    """The landmarks of each image, from the images near it."""
    return [_found(sights, number) for number in range(len(sights))]


def _found(sights: Sequence[Sight], number: int) -> Landmarks:
    sight = sights[number]
    lines = _lines(sights, number)
    used = lines.nearest(len(sight))
    for _ in range(NUM_ROUNDS):
        total, moment = lines.information(used, len(sight))
        known = np.linalg.eigvalsh(total)[:, 0] > MIN_PARALLAX**2 / 2.0
        points = np.full((len(sight), 3), np.nan)
        points[known] = np.linalg.solve(total[known], moment[known, :, None])[..., 0]
        error = lines.error_px(points)
        used = (error < MAX_ERROR_PX).astype(np.float64)
    kept = np.flatnonzero(known & (used[: len(sight)] > 0.0) & (_count(lines, used, sight) > 1))
    return Landmarks(
        sight=sight, rooted=sight.rooted[kept], points=points[kept],
        covariance=_covariance(lines, used, points, kept),
    )  # fmt: skip


def _count(lines: _Lines, used: Array, sight: Sight) -> Array:
    return np.asarray(np.bincount(lines.row, used, len(sight)), np.float64)


def _covariance(lines: _Lines, used: Array, points: Array, kept: Rows) -> Array:
    """Covariance (L, 3, 3) of points, those of lines that are used."""
    away = np.linalg.norm(points[lines.row] - lines.eye, axis=1)
    weight = np.where(used > 0.0, (lines.focal_px / (SIGMA_PX * away)) ** 2, 0.0)
    total, _ = lines.information(weight, len(points))
    floor = 1e-9 * np.trace(total[kept], axis1=1, axis2=2)[:, None, None] * np.eye(3)
    return np.asarray(np.linalg.inv(total[kept] + floor), np.float64)


def _lines(sights: Sequence[Sight], number: int) -> _Lines:
    """The lines of sight of an image, followed by those of its neighbours."""
    sight = sights[number]
    found = [(np.arange(len(sight)), sight, np.arange(len(sight)))]
    for other in _neighbours(sights, number):
        own, there = matched(sight.rooted, other.rooted)
        near = _on_epipolar_line(sight, other, own, there)
        found.append((own[near], other, there[near]))
    return _Lines(
        row=np.concatenate([own for own, _, _ in found]),
        eye=np.concatenate([np.broadcast_to(one.eye, (len(own), 3)) for own, one, _ in found]),
        direction=np.concatenate([one.directions[there] for _, one, there in found]),
        focal_px=np.concatenate([np.full(len(own), one.focal_px) for own, one, _ in found]),
    )


def _neighbours(sights: Sequence[Sight], number: int) -> list[Sight]:
    """The nearest images, from other places, that look the same way."""
    away = np.linalg.norm([one.eye - sights[number].eye for one in sights], axis=1)
    alike = np.array([one.ahead @ sights[number].ahead for one in sights]) > MIN_COSINE
    order = np.argsort(away, kind="stable")
    return [sights[one] for one in order if alike[one] and away[one] > 0.0][:NUM_NEIGHBOURS]


def _on_epipolar_line(one: Sight, other: Sight, own: Rows, there: Rows) -> NDArray[np.bool_]:
    """Mask (M,) of the matches whose lines of sight may meet."""
    plane = np.cross(other.eye - one.eye, one.directions[own])
    across = np.einsum("ni,ni->n", plane, other.directions[there])
    near: NDArray[np.bool_] = np.abs(across) * other.focal_px <= MAX_ERROR_PX * np.linalg.norm(
        plane, axis=1
    )
    return near
