"""Orbits: poses all round the objects of a map, told apart by texture and by what is behind.

The shape of a round object fixes the distance and direction of a camera, but not the side from
which it is seen. Each pose that fits an object is carried round it; texture says where to stop.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from recon.camera import StereoRig
from recon.localisation.contest import Contender, decide
from recon.localisation.directions import Directions
from recon.localisation.registration import Points, inverse
from recon.localisation.search import (
    MIDDLE_DEG,
    MIN_POINTS,
    Search,
    Summit,
    directions,
    some,
)
from recon.localisation.silhouettes import agreement
from recon.localisation.stance import tilt_by
from recon.localisation.steps import difference, stepped, turned
from recon.localisation.texture import Texture
from recon.records import FitFailure, FoundObject, PointCloud, PoseEstimate

Array = NDArray[np.float64]

NUM_FEW = 250
"""Points that are registered."""
NUM_BEARINGS, DEPTH_SHARES = 8, (0.2, 0.5)
"""Sides from which an object is tried, and the share of its width by which its axis lies behind its
front."""
NUM_CLIMBED, NUM_ORBITS = 3, 3
"""Starts at each object that are climbed, and fits that are carried round their objects."""
MOST_WORSE = 25.0
"""Fits with so much less evidence than the best are not carried round."""
SAME_DISTANCE_CELLS = 1.0
ORBIT_STEP_DEG, NUM_PEAKS = 2.0, 4
NUM_BARE = 12
"""Poses of an orbit that are contenders whatever their texture ..."""
NUM_LIKELY = 2
"""... and the most likely of them by shape, which are improved."""
TWINS_DEG = (90.0, 120.0, 180.0, 240.0, 270.0)
"""Turns that may leave the texture of a round object as it is."""
BLUR_PX = 1.5
"""Standard deviation of the blur at which an orbit is searched."""
STEPS = np.array([1.5, 0.6, 0.02])
"""First steps of a pose that is improved: degrees about an object, degrees about the camera, and
share of the distance."""
MOST_TRIED = 35
OWN_CELLS, OWN_DEG = 0.12, 0.2
"""Standard deviations of the places of texels: all of an object share them."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fit:
    """A pose at which a pair fits an object of the map."""

    estimate: PoseEstimate
    evidence: float
    centre: Array
    """(3,) of the object."""

    @property
    def distance(self) -> float:
        """Horizontal distance of the camera from the axis of the object."""
        return math.hypot(*(self.estimate.T_world_left[:3, 3] - self.centre)[[0, 2]])

    def turned(self, degrees: float) -> Array:
        """The pose after a turn round the object."""
        return turned(self.estimate.T_world_left, self.centre, degrees)


@dataclass(frozen=True, kw_only=True, eq=False)
class Orbits:
    """The objects of a map, from all sides."""

    search: Search
    objects: tuple[FoundObject, ...]
    texture: Texture

    @classmethod
    def of(
        cls,
        search: Search,
        objects: tuple[FoundObject, ...],
        views: Iterable[tuple[PointCloud, Array]],
    ) -> "Orbits | None":
        """The objects of a searched map; None if its points have no colours."""
        texture = Texture.of(views, search.surfels)
        return None if texture is None else cls(search=search, objects=objects, texture=texture)

    def recall(
        self, points: Points, rig: StereoRig, image: NDArray[np.uint8], known: list[PoseEstimate]
    ) -> PoseEstimate | FitFailure:
        """The pose of a pair from its points, its left image (grey) and similar known places."""
        if len(points) < MIN_POINTS:
            return FitFailure("too little is seen")
        taken = Taken(points=points, rig=rig, image=image)
        found = [one for fit in self._fits(taken) for one in self._round(taken, fit)]
        found += [one for estimate in known for one in self._known(taken, estimate)]
        return decide(found, self.search.shape.size)

    def _fits(self, taken: "Taken") -> list[Fit]:
        """Poses at which objects of the map are where the pair sees its nearest thing."""
        seen = {p: taken.directions(p, MIDDLE_DEG) for p in self.search.stance.pitches}
        starts = [(one, start) for one in self.objects for start in self._starts(one, seen)]
        fits = []
        for one, start in starts:
            top = self.search.climbed(start, self.search.shape, seen[start.pitch])
            T_world_left = self.search.stance.at(top.place, top.pitch)
            found = self.search.registered(taken.few, T_world_left)
            if found is not None:
                evidence = self._evidence(taken, found.T_world_left)
                fits.append(Fit(estimate=found, evidence=evidence, centre=one.centre))
        return self._distinct(fits)

    def _distinct(self, fits: list[Fit]) -> list[Fit]:
        """The best fits that are on different orbits."""
        kept: list[Fit] = []
        for one in sorted(fits, key=lambda one: -one.evidence):
            same = [other for other in kept if np.array_equal(other.centre, one.centre)]
            near = SAME_DISTANCE_CELLS * self.search.shape.size
            if all(abs(one.distance - other.distance) > near for other in same):
                kept.append(one)
        return [one for one in kept if one.evidence > kept[0].evidence - MOST_WORSE][:NUM_ORBITS]

    def _starts(self, one: FoundObject, seen: dict[float, Directions]) -> list[Summit]:
        """The best of rough poses round an object."""
        starts = []
        for pitch, view in seen.items():
            near = np.empty((view.grid.num_columns, view.grid.num_rows))
            ahead, aside = view.seen.pivot
            for place in _places(one, float(ahead), float(aside)):
                value = agreement(
                    self.search.shape, place, self.search.stance.height, view.grid, view.seen, near
                )
                starts.append(Summit(place=place, pitch=pitch, value=value))
        starts.sort(key=lambda start: -start.value)
        return starts[:NUM_CLIMBED]

    def _round(self, taken: "Taken", fit: Fit) -> list[Contender]:
        """Contenders on the orbit of a fit."""
        turns = np.arange(0.0, 360.0, ORBIT_STEP_DEG)
        value = np.array([self._value(taken.blurred, taken, fit.turned(turn)) for turn in turns])
        tops = np.flatnonzero((value >= np.roll(value, 1)) & (value >= np.roll(value, -1)))
        tops = tops[np.argsort(-value[tops], kind="stable")][:NUM_PEAKS]
        bare = [fit.turned(360.0 * k / NUM_BARE) for k in range(NUM_BARE)]
        others = [self._judged(taken, replace(fit.estimate, T_world_left=T)) for T in bare]
        likely = sorted(others, key=lambda one: -one.evidence)[:NUM_LIKELY]
        starts = [
            *(fit.turned(turns[top]) for top in tops),
            *(one.estimate.T_world_left for one in likely),
        ]
        return [*others, *(one for T in starts for one in self._twins(taken, T, fit.centre))]

    def _known(self, taken: "Taken", estimate: PoseEstimate) -> list[Contender]:
        """The pose of a known place and its twins."""
        T_world_left = estimate.T_world_left
        depth = float(np.median(taken.points.points_left[:, 2]))
        ahead = T_world_left[:3, 3] + T_world_left[:3, 2] * depth
        one = min(self.objects, key=lambda one: float(np.linalg.norm(one.centre - ahead)))
        return self._twins(taken, T_world_left, one.centre)

    def _twins(self, taken: "Taken", T_world_left: Array, centre: Array) -> list[Contender]:
        """A pose after it is improved, and its twins; nothing if it is not on the map."""
        best = self._improved(taken, T_world_left, centre)
        found = self.search.registered(taken.few, best)
        if found is None:
            return []
        value = self._value(taken.sharp, taken, best)
        if value > 0.0:
            # Texture is more precise than shape.
            information = self._information(taken, best, centre, value)
            covariance = inverse(inverse(found.covariance) + information) + self._own()
            found = replace(found, T_world_left=best, covariance=covariance)
        poses = [turned(found.T_world_left, centre, twin) for twin in (0.0, *TWINS_DEG)]
        return [self._judged(taken, replace(found, T_world_left=T)) for T in poses]

    def _own(self) -> Array:
        """Covariance (6, 6) that the errors of the map's texture add."""
        shift = OWN_CELLS * self.search.shape.size
        return np.diag(np.repeat([np.radians(OWN_DEG), shift], 3) ** 2)

    def _judged(self, taken: "Taken", estimate: PoseEstimate) -> Contender:
        """A pose with its evidence."""
        return Contender(
            estimate=estimate,
            evidence=self._evidence(taken, estimate.T_world_left),
            likeness=self.texture.likeness(taken.sharp, taken.rig, estimate.T_world_left),
        )

    def _evidence(self, taken: "Taken", T_world_left: Array) -> float:
        return self.search.evidence(taken.points, taken.rig, T_world_left)

    def _value(self, image: NDArray[np.float32], taken: "Taken", T_world_left: Array) -> float:
        return self.texture.likeness(image, taken.rig, T_world_left).total

    def _improved(self, taken: "Taken", T_world_left: Array, centre: Array) -> Array:
        """The pose of best texture near another (Nelder and Mead 1965)."""
        found = self.search.registered(taken.few, T_world_left)
        best = T_world_left if found is None else found.T_world_left
        for image, size in ((taken.blurred, 1.0), (taken.sharp, 0.4)):
            best = self._climbed(image, taken, best, (centre, size))
        return best

    def _climbed(
        self, image: NDArray[np.float32], taken: "Taken", start: Array, about: tuple[Array, float]
    ) -> Array:
        """The pose of best texture from steps of a size about a centre."""
        centre, size = about

        def cost(step: Array) -> float:
            return -self._value(image, taken, stepped(start, centre, step))

        options: Any = {
            "initial_simplex": np.vstack([np.zeros(3), size * np.diag(STEPS)]),
            "maxfev": MOST_TRIED, "fatol": 0.1,
        }  # fmt: skip
        solved = minimize(cost, np.zeros(3), method="Nelder-Mead", options=options)
        return stepped(start, centre, np.asarray(solved.x, np.float64))

    def _information(
        self, taken: "Taken", T_world_left: Array, centre: Array, value: float
    ) -> Array:
        """What the curvature of the evidence of texture says about a pose (6, 6)."""
        information = np.zeros((6, 6))
        for step in np.diag(STEPS):
            there = stepped(T_world_left, centre, step)
            back = stepped(T_world_left, centre, -step)
            sides = self._value(taken.sharp, taken, there) + self._value(taken.sharp, taken, back)
            way = difference(T_world_left, there)
            information += max(0.0, 2.0 * value - sides) * np.outer(way, way) / (way @ way) ** 2
        return information


@dataclass(frozen=True, kw_only=True, eq=False)
class Taken:
    """A pair as taken: its points and its left image."""

    points: Points
    rig: StereoRig
    image: NDArray[np.uint8]

    @cached_property
    def few(self) -> Points:
        """Points enough to be registered."""
        return some(self.points, NUM_FEW)

    @cached_property
    def sharp(self) -> NDArray[np.float32]:
        """The image as numbers."""
        return self.image.astype(np.float32)

    @cached_property
    def blurred(self) -> NDArray[np.float32]:
        """The image in which poses are searched: a small error does not matter."""
        blurred: NDArray[np.float32] = cv2.GaussianBlur(self.sharp, (0, 0), BLUR_PX)
        return blurred

    def directions(self, pitch: float, degrees: float) -> Directions:
        """What is seen if the camera looks up by an angle."""
        return directions(self.points, self.rig, tilt_by(pitch), degrees)


def _places(one: FoundObject, ahead: float, aside: float) -> list[Array]:
    """Places x, z, azimuth from which an object is where something is seen."""
    bearing, reach = math.atan2(aside, ahead), math.hypot(ahead, aside)
    places = []
    for share in DEPTH_SHARES:
        away = reach + share * max(one.size[0], one.size[2])
        for side in np.linspace(0.0, 2.0 * np.pi, NUM_BEARINGS, endpoint=False):
            x = one.centre[0] - away * math.cos(side)
            z = one.centre[2] - away * math.sin(side)
            places.append(np.array([x, z, side - bearing]))
    return places
