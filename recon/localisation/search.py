"""Search: where in a map a robot may stand, over all positions and headings.

Correlative scan matching (Olson 2009) with a camera instead of a laser: a coarse sweep bounds the
agreement of every position and heading from above, as in branch and bound (Hess et al. 2016); the
best ones are climbed and registered. One likelihood decides among them and the known places.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.camera import StereoRig
from recon.geometry import pose, rotation_about_y, wrapped
from recon.localisation.atlas import Atlas
from recon.localisation.candidates import COVERED_SHARE, Candidate, decide, distinct
from recon.localisation.completion import completed, thinned
from recon.localisation.directions import Directions, all_round
from recon.localisation.graph import planar
from recon.localisation.locate import estimate_of
from recon.localisation.registration import LAST_REACH, Points, register, slid, touch
from recon.localisation.silhouettes import MOST_SIGMAS_SQ, Shape, agreement, climb, sweep
from recon.localisation.stance import Stance, tilt_by, tilt_of
from recon.localisation.surfels import Surfels
from recon.records import FitFailure, FoundObject, PoseEstimate, Voxels

Array = NDArray[np.float64]

COARSE_DEG, MIDDLE_DEG, FINE_DEG = 3.0, 1.5, 0.5
"""Sides of the directions in which poses are swept, climbed and compared."""
SPACING_CELLS, SLACK_SHARE = 2.0, 0.75
"""Distance of the positions of the sweep, and the share of it that is within their reach."""
MOST_DRAWN = 10_000_000
"""Maps with more coarse cells, drawn from all positions, are not searched: it would take too long,
and features are more reliable there."""
AROUND_CELLS, FREE_CELLS = 10.0, 1.5
"""Positions lie so far around everything known, and so far from what stands at the camera's
height."""
NUM_STARTS, NUM_CLIMBED, NUM_CANDIDATES = 100, 50, 16
"""Bounds that are climbed at each pitch, coarse summits that are climbed on, and summits that are
registered."""
NUM_REGISTERED = 700
"""Points that a summit is registered with."""
ORBIT_DEG = (-6.0, -4.0, -2.0, 2.0, 4.0, 6.0)
NEAREST_SHARE = 0.3
"""Turns of the best pose about the nearest share of the points, from which it is registered
again."""
MIN_POINTS = 30
SHARED = 2.0
"""Neighbouring cells share the errors of the solids fitted to them: so many count as one."""
CELLS_PER_E = 10.0
"""Number of cells, one standard deviation squared off, that make a pose e times less likely."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Search:
    """A map to be searched by cameras of one stance."""

    stance: Stance
    shape: Shape
    """All surfaces of the map."""
    coarse: Shape
    surfels: Surfels
    places: Array
    """(P, 3) x, y, z of the positions of the sweep."""

    @classmethod
    def of(cls, voxels: Voxels, objects: tuple[FoundObject, ...], atlas: Atlas) -> "Search | None":
        """The search of a map; None if it is too large or its cameras do not share a stance."""
        cell = voxels.cell_size
        stance = Stance.of(atlas.T_world_left, cell)
        if stance is None or not len(voxels):
            return None
        points, seen_from = completed(voxels, objects), atlas.T_world_left[:, :3, 3]
        spacing = SPACING_CELLS * cell
        coarse, extent = thinned(points, spacing), _extent(points, seen_from, cell)
        if np.prod(np.ptp(extent, axis=0) / spacing) * len(coarse) > MOST_DRAWN:
            return None
        return cls(
            stance=stance,
            shape=Shape(points=points, size=cell),
            coarse=Shape(points=coarse, size=spacing),
            surfels=Surfels.through(points, cell),
            places=_places(points, stance.height, cell, extent),
        )

    def upright(self, estimate: PoseEstimate) -> PoseEstimate:
        """A pose in the stance of the run."""
        return self.stance.upright(estimate, self.shape.size)

    def recall(
        self, points: Points, rig: StereoRig, known: list[tuple[PoseEstimate, float]]
    ) -> PoseEstimate | FitFailure:
        """The pose of a pair from its points and known places, with what speaks for each."""
        if len(points) < MIN_POINTS:
            return FitFailure("too little is seen")
        return decide(self.candidates(points, rig, known), self.shape.size)

    def candidates(
        self, points: Points, rig: StereoRig, known: list[tuple[PoseEstimate, float]]
    ) -> list[Candidate]:
        """The distinct poses that may be true, the likeliest first."""
        few = _some(points, NUM_REGISTERED)
        starts = [*self._summits(points, rig), *(one.T_world_left for one, _ in known)]
        found = [self._registered(few, T) for T in starts]
        judged = [self.judged(one, points, rig) for one in found if one is not None]
        judged += [self.judged(one, points, rig, more) for one, more in known]
        if judged:
            best = max(judged, key=lambda one: one.evidence).estimate
            again = [self._registered(few, T) for T in _turned(few, best.T_world_left)]
            judged += [self.judged(one, points, rig) for one in again if one is not None]
        return distinct(judged, self.shape.size)

    def judged(
        self, estimate: PoseEstimate, points: Points, rig: StereoRig, known: float | None = None
    ) -> Candidate:
        """A pose with its evidence, to which that of a known place is added."""
        evidence = self._evidence(points, rig, estimate.T_world_left)
        if known is None:
            return Candidate(estimate=estimate, evidence=evidence)
        reach = COVERED_SHARE * float(np.median(points.points_left[:, 2]))
        return Candidate(estimate=estimate, evidence=evidence + known, is_known=True, reach=reach)

    def _summits(self, points: Points, rig: StereoRig) -> list[Array]:
        """Poses (4, 4) of best agreement, the best first."""
        found = self._starts(points, rig)
        cell = self.shape.size
        for shape, degrees, most in (
            (self.coarse, COARSE_DEG, NUM_CLIMBED), (self.shape, MIDDLE_DEG, NUM_CANDIDATES),
        ):  # fmt: skip
            seen = {
                pitch: _directions(points, rig, tilt_by(pitch), degrees)
                for pitch in self.stance.pitches
            }
            found = _distinct([self._climbed(one, shape, seen[one.pitch]) for one in found], cell)
            found = found[:most]
        return [self.stance.at(one.place, one.pitch) for one in found]

    def _climbed(self, start: "Summit", shape: Shape, seen: Directions) -> "Summit":
        step = self.shape.size
        place, value = climb(shape, start.place, self.stance.height, seen.grid, seen.seen, step)
        return Summit(place=place, pitch=start.pitch, value=value)

    def _starts(self, points: Points, rig: StereoRig) -> list["Summit"]:
        """The best bounds at each pitch."""
        grid, views = all_round(
            [_directions(points, rig, tilt_by(p), COARSE_DEG) for p in self.stance.pitches]
        )
        slack = SLACK_SHARE * self.coarse.size
        bound = sweep(self.coarse, self.places, slack, grid, views)
        return [
            one
            for view, pitch in enumerate(self.stance.pitches)
            for one in self._best(bound[:, view], pitch, grid.side)
        ]

    def _best(self, bound: NDArray[np.float32], pitch: float, side: float) -> list["Summit"]:
        """The best of bounds (P, A) by position and heading, one of neighbouring ones."""
        order = np.argsort(-bound, axis=None, kind="stable")[: 200 * NUM_STARTS]
        row, turn = np.unravel_index(order, bound.shape)
        at, value = self.places[row][:, [0, 2]], bound[row, turn]
        block = np.column_stack([at // (2.0 * self.coarse.size), turn // 3])
        _, first = np.unique(block, axis=0, return_index=True)
        best = np.sort(first)[:NUM_STARTS]
        places = np.column_stack([at, (turn + 0.5) * side])
        return [
            Summit(place=places[one], pitch=pitch, value=float(value[one]))
            for one in best
            if np.isfinite(value[one])
        ]

    def _registered(self, points: Points, T_world_left: Array) -> PoseEstimate | None:
        prior = self.stance.prior(T_world_left, self.shape.size)
        found = register(points, self.surfels, prior, slides=True)
        if found is None:
            return None
        return estimate_of(replace(found, information=found.information / SHARED), points, prior)

    def _evidence(self, points: Points, rig: StereoRig, T_world_left: Array) -> float:
        """Log likelihood of a pose: of what is seen and not seen, and how well surfaces fit."""
        fine = _directions(points, rig, tilt_of(T_world_left), FINE_DEG)
        near = np.empty((fine.grid.num_columns, fine.grid.num_rows))
        place = planar(T_world_left)
        seen: float = agreement(self.shape, place, self.stance.height, fine.grid, fine.seen, near)
        few = _some(points, NUM_REGISTERED)
        reach = LAST_REACH * self.shape.size
        fit = touch(slid(few, self.surfels, T_world_left), self.surfels, T_world_left, reach)
        share = max(fit.num_points, 1) / len(few)
        off = float(np.minimum(fit.residual**2, MOST_SIGMAS_SQ).sum())
        # Points off the map count as cells would.
        off += MOST_SIGMAS_SQ * len(fit.residual) * (1.0 - share) / share
        return seen - off / (2.0 * CELLS_PER_E)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Summit:
    """A place and pitch, and how well a pair agrees with the map there."""

    place: Array
    """(3,) x, z, and the azimuth of straight ahead."""
    pitch: float
    value: float

    def is_near(self, other: "Summit", cell_size: float) -> bool:
        """True if both would be registered to the same pose."""
        x, z, turn = self.place - other.place
        return math.hypot(x, z) < 1.5 * cell_size and abs(float(wrapped(turn))) < 0.1


def _distinct(summits: list[Summit], cell_size: float) -> list[Summit]:
    """The distinct summits, the best first."""
    kept: list[Summit] = []
    for one in sorted(summits, key=lambda one: -one.value):
        if not any(one.is_near(other, cell_size) for other in kept):
            kept.append(one)
    return kept


def _directions(points: Points, rig: StereoRig, tilt: Array, degrees: float) -> Directions:
    level = points.points_left @ tilt.T
    return Directions.of(level, points.sigma, rig, tilt, math.radians(degrees))


def _turned(points: Points, T_world_left: Array) -> list[Array]:
    """Poses (4, 4) turned about what is nearest: registration may end beside the best of them."""
    depth = points.points_left[:, 2]
    near = points.points_left[depth <= np.quantile(depth, NEAREST_SHARE)].mean(axis=0)
    pivot = T_world_left[:3, :3] @ near + T_world_left[:3, 3]
    turns = [rotation_about_y(math.radians(degrees)) for degrees in ORBIT_DEG]
    return [pose(turn, pivot - turn @ pivot) @ T_world_left for turn in turns]


def _some(points: Points, number: int) -> Points:
    """Evenly chosen points."""
    rows = np.unique(np.linspace(0, len(points) - 1, number).astype(np.intp))
    return points.select(rows)


def _extent(points: Array, seen_from: Array, cell: float) -> Array:
    """Corners (2, 2) in x, z of the area where a pair may have been taken."""
    known = np.vstack([points, seen_from])[:, [0, 2]]
    around = AROUND_CELLS * cell
    return np.array([known.min(axis=0) - around, known.max(axis=0) + around])


def _places(points: Array, height: float, cell: float, extent: Array) -> Array:
    """Positions (P, 3) of the sweep: everywhere in an area but in what stands there."""
    axes = [np.arange(low, high, SPACING_CELLS * cell) for low, high in extent.T]
    x, z = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    places = np.column_stack([x, np.full(len(x), height), z])
    body = points[np.abs(points[:, 1] - height) < FREE_CELLS * cell]
    if not len(body):
        return places
    away, _ = cKDTree(body[:, [0, 2]]).query(places[:, [0, 2]])
    free: Array = places[away > FREE_CELLS * cell]
    return free
