"""The graph of a walk: poses on the floor, connected by steps and by the objects seen from them.

Landmark SLAM in the plane: steps have the uncertainty of the motion, sightings that of stereo; all
poses and landmarks are adjusted together, so that returning to known objects corrects the whole
path (Thrun and Montemerlo 2006, GraphSLAM).
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from recon.geometry import wrapped
from recon.localisation.blocks import Block
from recon.localisation.links import ROBUST, Link, led_by, links_block, step_derivatives

Array = NDArray[np.float64]

NUM_ROUNDS = 12
SMALL_CHANGE = 1e-5
FIRST_SIGMA = 1e-5
"""Standard deviation of the first pose, which anchors the world; radians and world units."""
WIDTH_QUANTILE = 0.6
"""Of the widths that a thing was seen in, the one that counts."""
SHAPE_SHARE, NUM_SHAPE = 0.03, 2.0
"""Standard deviation of the middle between the edges of a thing as a share of its radius, before
it was seen, and so many sightings that counts as: a tree looks the same from all sides, a house
does not."""
FRONT_SHARE = 0.7
"""Typical distance of an object's front from its centre, as a share of its radius ..."""
FRONT_SIGMA = 0.35
"""... and the standard deviation of that share."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bearing:
    """An object as seen by a pair."""

    pose: int
    """Number of the pair."""
    landmark: int
    azimuth_rad: float
    """Relative to straight ahead, increasing clockwise seen from above."""
    distance: float
    """To its front, world units."""
    azimuth_sigma: float
    """Of the edges; the shape of the object adds to it."""
    distance_sigma: float
    half_rad: float = np.nan
    """Half the angle between its edges; NaN if one of them is hidden."""


def hidden_rad(half_rad: Array, radius: Array, away: Array) -> Array:
    """Angles (N,) by which objects appear too narrow or too wide, and their middle may be off.

    An object that appears too narrow is partly hidden; one too wide has another beside it or behind
    it, however little of it shows.
    """
    half = np.arcsin(np.minimum(radius / away, 1.0))
    return np.where(np.isnan(half_rad), 0.0, np.abs(half_rad - half))


def planar(T_world_left: Array) -> Array:
    """x, z of a camera and the azimuth of straight ahead (3,)."""
    ahead = T_world_left[:3, 2]
    return np.array([*T_world_left[[0, 2], 3], np.arctan2(ahead[2], ahead[0])])


@dataclass(slots=True, kw_only=True, eq=False)
class Graph:
    """A walk and its landmarks; `solve` adjusts them."""

    poses: Array
    """(N, 3) x, z, azimuth of straight ahead."""
    links: list[Link] = field(default_factory=list)
    """Intended steps, and measured motions between pairs that show the same."""
    step_sigma: tuple[float, float]
    """Standard deviations of position along each axis, world units, and heading, radians."""
    landmarks: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """(M, 3) x, z of the centre, and the distance of the front from it."""
    radii: Array = field(default_factory=lambda: np.zeros(0))
    """(M,) half the width of each."""
    shapes: Array = field(default_factory=lambda: np.zeros(0))
    """(M,) how far the middle between the edges is off, as a share of that half width."""
    bearings: list[Bearing] = field(default_factory=list)

    @classmethod
    def at(cls, pose: Array, step_sigma: tuple[float, float]) -> "Graph":
        """A walk that starts at a pose (3,)."""
        return cls(poses=pose[None], step_sigma=step_sigma)

    def walk(self, step: Array) -> None:
        """Add the intended pose after a step (3,)."""
        last = self.poses[-1:]
        self.poses = np.vstack([self.poses, last + led_by(last, step[None])])
        position, heading = self.step_sigma
        number = len(self.poses) - 1
        information = np.diag([position**-2.0, position**-2.0, heading**-2.0])
        self.links.append(
            Link(first=number - 1, second=number, step=step, information=information, is_sure=True)
        )

    def add(self, place: Array, radius: float) -> int:
        """Add a landmark at x, z; returns its number."""
        self.landmarks = np.vstack([self.landmarks, [*place, FRONT_SHARE * radius]])
        self.radii = np.append(self.radii, radius)
        self.shapes = np.append(self.shapes, SHAPE_SHARE)
        return len(self.radii) - 1

    def solve(self) -> None:
        """Adjust poses and landmarks to all steps and sightings."""
        for _ in range(NUM_ROUNDS):
            jacobian, residual = self._equations()
            normal = csc_array(jacobian.T @ jacobian)
            change: Array = -splu(normal).solve(np.asarray(jacobian.T @ residual))
            num = 3 * len(self.poses)
            self.poses = self.poses + change[:num].reshape(-1, 3)
            self.landmarks = self.landmarks + change[num:].reshape(-1, 3)
            if np.abs(change).max() < SMALL_CHANGE:
                break
        self._resize()

    def _resize(self) -> None:
        """Widths and shapes of landmarks by the angles that they were seen under."""
        seen = [bearing for bearing in self.bearings if not np.isnan(bearing.half_rad)]
        mark = np.array([bearing.landmark for bearing in seen], np.intp)
        pose = self.poses[[bearing.pose for bearing in seen]]
        offset = self.landmarks[mark, :2] - pose[:, :2]
        away = np.hypot(*offset.T)
        half = np.array([bearing.half_rad for bearing in seen])
        azimuth = np.array([bearing.azimuth_rad for bearing in seen])
        off = np.abs(wrapped(np.arctan2(offset[:, 1], offset[:, 0]) - pose[:, 2] - azimuth)) * away
        for landmark in np.unique(mark):
            rows = mark == landmark
            radius = np.quantile(away[rows] * np.sin(half[rows]), WIDTH_QUANTILE)
            usual, known = np.median(off[rows]) / radius / 0.6745, rows.sum()
            self.radii[landmark] = radius
            self.shapes[landmark] = np.sqrt(
                (NUM_SHAPE * SHAPE_SHARE**2 + known * usual**2) / (NUM_SHAPE + known)
            )

    def off_middle_rad(self, mark: NDArray[np.intp], half_rad: Array, away: Array) -> Array:
        """Standard deviation (N,) of the middle of what is seen of landmarks from their own."""
        radius = self.radii[mark]
        shape = self.shapes[mark] * radius / away
        return np.hypot(shape, hidden_rad(half_rad, radius, away))

    def joint_covariance(self, number: int) -> Array:
        """(3 + 3 M) square, of a pose and of the landmarks."""
        marks = np.arange(3 * len(self.poses), 3 * len(self.poses) + self.landmarks.size)
        return self._spread(np.concatenate([np.arange(3) + 3 * number, marks]))

    def covariance(self) -> Array:
        """(3, 3) of the last pose."""
        return self._spread(np.arange(3) + 3 * (len(self.poses) - 1))

    def spread_between(self, number: int) -> Array:
        """Covariance (3, 3) of the step from an earlier pose to the last one."""
        both = self._spread(np.arange(3) + 3 * np.array([[number], [len(self.poses) - 1]]))
        by_both = step_derivatives(self.poses[[number]], self.poses[-1:])[0]
        spread: Array = by_both @ both @ by_both.T
        return spread

    def _spread(self, unknowns: NDArray[np.intp]) -> Array:
        """The covariance of some unknowns."""
        jacobian, _ = self._equations()
        rows = unknowns.ravel()
        unit = np.zeros((jacobian.shape[1], len(rows)))
        unit[rows, np.arange(len(rows))] = 1.0
        spread: Array = splu(csc_array(jacobian.T @ jacobian)).solve(unit)[rows]
        return (spread + spread.T) / 2.0

    def _equations(self) -> tuple["csc_array[np.float64]", Array]:
        """Derivatives (R, 3 N + 3 M) and residuals (R,), in standard deviations."""
        parts = [self._anchor(), links_block(self.links, self.poses)]
        parts += [self._of_bearings(), self._of_fronts()]
        residual = np.concatenate([part.residual for part in parts])
        starts = np.cumsum([0, *(len(part.residual) for part in parts)])
        rows = np.concatenate([p.rows + start for p, start in zip(parts, starts, strict=False)])
        columns = np.concatenate([part.columns for part in parts])
        values = np.concatenate([part.values for part in parts])
        shape = (len(residual), 3 * (len(self.poses) + len(self.landmarks)))
        return csc_array((values, (rows, columns)), shape=shape), residual

    def _anchor(self) -> Block:
        return Block.of(np.zeros(3), np.full((3, 1), 1.0 / FIRST_SIGMA), np.arange(3)[:, None])

    def _of_bearings(self) -> Block:
        """Residuals of the sightings: seen minus expected positions of objects."""
        seen = self.bearings
        pose = np.array([bearing.pose for bearing in seen], np.intp)
        mark = np.array([bearing.landmark for bearing in seen], np.intp)
        at, of = self.poses[pose], self.landmarks[mark]
        offset = of[:, :2] - at[:, :2]
        range_sq = np.maximum((offset**2).sum(axis=1), 1e-9)
        distance = np.sqrt(range_sq)
        measured = np.array([(b.azimuth_rad, b.distance) for b in seen]).reshape(-1, 2)
        sigma = np.array([(b.azimuth_sigma, b.distance_sigma) for b in seen]).reshape(-1, 2)
        half = np.array([bearing.half_rad for bearing in seen])
        sigma[:, 0] = np.hypot(sigma[:, 0], self.off_middle_rad(mark, half, distance))
        azimuth = np.arctan2(offset[:, 1], offset[:, 0]) - at[:, 2]
        aside, ahead = azimuth - measured[:, 0], distance - of[:, 2] - measured[:, 1]
        off = np.column_stack([wrapped(aside), ahead])
        across = np.column_stack([-offset[:, 1], offset[:, 0]]) / range_sq[:, None]
        along, one = offset / distance[:, None], np.ones((len(seen), 1))
        derivative = np.stack(
            [
                np.column_stack([-across, -one, across, 0 * one]),
                np.column_stack([-along, 0 * one, along, -one]),
            ],
            axis=1,
        )
        residual = off / sigma
        # Joint Cauchy weights, since a confused object may be wrong in either.
        weight = 1.0 / np.sqrt(1.0 + (residual**2).sum(axis=1) / ROBUST**2)
        scaled = derivative / sigma[..., None] * weight[:, None, None]
        columns = np.column_stack(
            [3 * pose[:, None] + np.arange(3), 3 * (len(self.poses) + mark[:, None]) + np.arange(3)]
        )
        return Block.of(
            (residual * weight[:, None]).ravel(), scaled.reshape(-1, 6), columns.repeat(2, axis=0)
        )

    def _of_fronts(self) -> Block:
        """Prior knowledge of the front of an object."""
        number = len(self.radii)
        sigma = np.maximum(FRONT_SIGMA * self.radii, 1e-3)
        columns = 3 * (len(self.poses) + np.arange(number)) + 2
        off = self.landmarks[:, 2] - FRONT_SHARE * self.radii
        return Block.of(off / sigma, 1.0 / sigma[:, None], columns[:, None])
