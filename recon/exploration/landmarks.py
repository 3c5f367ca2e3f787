"""Landmarks: the objects of a belief's graph as they are expected in view."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from recon.exploration.floor import Array
from recon.exploration.outlines import Outline
from recon.geometry import wrapped
from recon.localisation.graph import FRONT_SHARE, Bearing, Graph

EDGE_SIGMA_PX = 0.2
"""Standard deviation of an edge, pixels."""
HIDDEN_SHARE = 0.1
"""Standard deviation of an object's middle derived from one edge, as a share of its radius."""
DISTANCE_SHARE, HIDDEN_DISTANCE_SHARE = 0.06, 0.5
"""The same for the distance of its front: for a whole object, and for a partly hidden one."""
GATE = 3.0
"""Standard deviations within which an object may be a landmark."""
SAME_WIDTH, WIDTH_PX = 1.5, 1.0
"""Ratio of the widths up to which an object seen whole may be a landmark, and the error of its
width, pixels: whatever else is uncertain, a landmark twice as wide is another thing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Expected:
    """All landmarks as they are expected from a pose."""

    azimuth_rad: Array
    """(M,) azimuths of their middles, from straight ahead."""
    range: Array
    """(M,) distance of their middles, world units."""
    front: Array
    """(M,) distance of their fronts, world units."""
    half_rad: Array
    """(M,) half the angle between their edges."""
    derivative: Array
    """(M, 2, 6) derivative of azimuth and front by the pose and by the landmark."""

    @classmethod
    def of(cls, graph: Graph, pose: Array) -> "Expected":
        """The landmarks of a graph from a pose (3,)."""
        offset = graph.landmarks[:, :2] - pose[:2]
        away = np.maximum(np.hypot(*offset.T), 1e-6)
        across = np.column_stack([-offset[:, 1], offset[:, 0]]) / away[:, None] ** 2
        along, one = offset / away[:, None], np.ones((len(away), 1))
        derivative = np.stack(
            [
                np.column_stack([-across, -one, across, 0 * one]),
                np.column_stack([-along, 0 * one, along, -one]),
            ],
            axis=1,
        )
        return cls(
            azimuth_rad=wrapped(np.arctan2(offset[:, 1], offset[:, 0]) - pose[2]),
            range=away,
            front=away - graph.landmarks[:, 2],
            half_rad=np.arcsin(np.minimum(graph.radii / away, 1.0)),
            derivative=derivative,
        )

    def spread(self, landmark: int, joint: Array) -> Array:
        """(2, 2) covariance of azimuth and front, from that (3 + 3 M) of pose and landmarks."""
        own = np.r_[0:3, 3 + 3 * landmark : 6 + 3 * landmark]
        by_both = self.derivative[landmark]
        spread: Array = by_both @ joint[np.ix_(own, own)] @ by_both.T
        return spread


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sighter:
    """The pose from which objects are seen, what is expected there, and its covariance."""

    graph: Graph
    number: int
    """Number of the pose."""
    expected: Expected
    joint: Array
    """(3 + 3 M) covariance of the pose and the landmarks."""
    edge_sigma: float
    """Standard deviation of an edge, radians."""

    @classmethod
    def of(cls, graph: Graph, focal_px: float, number: int = -1) -> "Sighter":
        """The sighter at a pose of a graph, by default the last one."""
        number %= len(graph.poses)
        return cls(
            graph=graph,
            number=number,
            expected=Expected.of(graph, graph.poses[number]),
            joint=graph.joint_covariance(number),
            edge_sigma=EDGE_SIGMA_PX / focal_px,
        )

    def bearing(self, seen: Outline, landmark: int) -> Bearing:
        """The sighting of a landmark with at least one visible edge."""
        radius, away = self.graph.radii[landmark], self.expected.range[landmark]
        return self._bearing(seen, landmark, float(radius), float(away))

    def _bearing(self, seen: Outline, landmark: int, radius: float, away: float) -> Bearing:
        half, is_whole = math.asin(min(radius / away, 1.0)), bool(seen.is_free.all())
        azimuth, edge, share = seen.middle_rad, self.edge_sigma / math.sqrt(2.0), 0.0
        hidden = HIDDEN_DISTANCE_SHARE * max(0.0, 1.0 - seen.half_rad / half)
        if not is_whole:
            azimuth = float(
                np.where(seen.is_free, seen.edges_rad + np.array([half, -half]), 0.0).sum()
            )
            edge, share = self.edge_sigma, HIDDEN_SHARE
        return Bearing(
            pose=self.number,
            landmark=landmark,
            azimuth_rad=azimuth,
            distance=seen.distance,
            azimuth_sigma=math.hypot(edge, share * radius / away),
            distance_sigma=math.hypot(seen.sigma, (DISTANCE_SHARE + hidden) * radius),
            half_rad=max(seen.half_rad, self.edge_sigma) if is_whole else math.nan,
        )

    def is_as_wide(self, seen: Outline, landmark: int) -> bool:
        """True if an object may be as wide as a landmark; of a hidden one this is not known."""
        if not seen.is_free.all():
            return True
        half = float(self.expected.half_rad[landmark])
        unsure = math.sqrt(float(self.expected.spread(landmark, self.joint)[1, 1]))
        error = WIDTH_PX * self.edge_sigma / EDGE_SIGMA_PX / max(min(half, seen.half_rad), 1e-6)
        limit = math.log(SAME_WIDTH) + GATE * unsure / self.expected.range[landmark] + error
        return bool(abs(math.log(max(seen.half_rad, 1e-6) / half)) < limit)

    @property
    def growth(self) -> float:
        """Standard deviation of a distance over its square."""
        return float(np.median([b.distance_sigma / b.distance**2 for b in self.graph.bearings]))

    def off(self, seen: Outline, landmark: int) -> Array:
        """(2,) differences in azimuth and in distance, whitened by their joint covariance."""
        off, noise, _ = self._compared(seen, landmark)
        spread = self.expected.spread(landmark, self.joint) + noise
        found: Array = np.linalg.solve(np.linalg.cholesky(spread), off)
        return found

    def joint_error(self, seen: Sequence[Outline], landmarks: Sequence[int]) -> float:
        """Squared standard deviations of several objects together; landmarks below 0 count not."""
        both = [(one, mark) for one, mark in zip(seen, landmarks, strict=True) if mark >= 0]
        parts = [self._compared(one, mark) for one, mark in both]
        off = np.concatenate([part[0] for part in parts])
        rows = np.vstack([part[2] for part in parts])
        whole = rows @ self.joint @ rows.T + block_diag(*(part[1] for part in parts))
        return float(off @ np.linalg.solve(whole, off))

    def _compared(self, seen: Outline, landmark: int) -> tuple[Array, Array, Array]:
        """Differences (2,), their noise (2, 2), and their derivative (2, 3 + 3 M)."""
        bearing = self.bearing(seen, landmark)
        mark, away = np.array([landmark]), self.expected.range[[landmark]]
        (middle,) = self.graph.off_middle_rad(mark, np.array([bearing.half_rad]), away)
        azimuth = wrapped(bearing.azimuth_rad - self.expected.azimuth_rad[landmark])
        off = np.array([azimuth, bearing.distance - self.expected.front[landmark]])
        noise = np.diag([bearing.azimuth_sigma**2 + middle**2, bearing.distance_sigma**2])
        rows = np.zeros((2, len(self.joint)))
        rows[:, :3] = self.expected.derivative[landmark, :, :3]
        rows[:, 3 + 3 * landmark : 6 + 3 * landmark] = self.expected.derivative[landmark, :, 3:]
        return off, noise, rows

    def add(self, seen: Outline) -> None:
        """Add a new landmark for a whole object."""
        x, z, heading = self.graph.poses[self.number]
        azimuth = heading + seen.middle_rad
        radius = seen.distance * math.tan(min(max(seen.half_rad, self.edge_sigma), 1.0))
        away = seen.distance + FRONT_SHARE * radius
        ahead = np.array([math.cos(azimuth), math.sin(azimuth)])
        landmark = self.graph.add(np.array([x, z]) + away * ahead, radius)
        self.graph.bearings.append(self._bearing(seen, landmark, radius, away))
