"""The points of a fit, and what several shapes start from: each is found once for all of them."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.algebra import spread
from recon.recognition.fitting.normals import estimate_normals
from recon.records import Sphere

Array = NDArray[np.float64]

PARALLEL = 0.998
"""Cosine of the angle below which two axes count as one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sample:
    """Points that solids are fitted to."""

    points: Array
    """(N, 3)"""
    weights: Array
    """(N,) relative."""

    @cached_property
    def share(self) -> Array:
        """(N,) how much each point counts, 1 on average."""
        share: Array = self.weights / self.weights.mean()
        return share

    @cached_property
    def normals(self) -> Array:
        """(N, 3)"""
        return estimate_normals(self.points)

    @cached_property
    def middle(self) -> Array:
        """(3,)"""
        middle: Array = self.points.mean(axis=0)
        return middle

    @cached_property
    def local(self) -> Array:
        """(N, 3) points about their middle."""
        return self.points - self.middle

    @cached_property
    def moments(self) -> Array:
        """(3, 3) covariance of the points."""
        count = len(self.points)
        moments: Array = spread(self.points) * (count / max(count - 1, 1))
        return moments

    @property
    def size(self) -> float:
        """Root of the points' variance."""
        return math.sqrt(np.trace(self.moments))

    @cached_property
    def principal(self) -> tuple[Array, Array]:
        """Variances (3,), ascending, and their directions, the rows (3, 3)."""
        values, vectors = np.linalg.eigh(self.moments)
        return values, np.ascontiguousarray(vectors.T)

    @cached_property
    def axes(self) -> Array:
        """Candidate axes (A, 3): where normals vary least, and the principal ones of points."""
        moments = np.stack([self.normals.T @ self.normals, spread(self.normals)])
        axes: list[Array] = []
        for axis in (*np.linalg.eigh(moments)[1][:, :, 0], *self.principal[1]):
            if all(abs(axis @ other) < PARALLEL for other in axes):
                axes.append(axis)
        return np.stack(axes)

    @cached_property
    def ball(self) -> Sphere:
        """The algebraic fit: ``|p|^2 = 2 c p + (r^2 - |c|^2)`` is linear in c and the rest."""
        system = np.column_stack([2.0 * self.local, np.ones(len(self.local))])
        solution = np.linalg.lstsq(system, (self.local**2).sum(axis=1), rcond=None)[0]
        radius_sq = max(float(solution[3] + solution[:3] @ solution[:3]), 1e-300)
        return Sphere(centre=self.middle + solution[:3], radius=float(np.sqrt(radius_sq)))
