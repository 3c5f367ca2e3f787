"""Posterior: how sure the likeliest standpoint is, and how precise."""

import math
from dataclasses import dataclass, replace

import numpy as np

from recon.geometry import WORLD_UP, Array
from recon.localisation.candidates import exact
from recon.localisation.corners import Corners
from recon.localisation.look import Look
from recon.localisation.odds import APART_CELLS, APART_RAD, Odds, per_e
from recon.localisation.portrait import Portrait
from recon.localisation.registration import moved
from recon.localisation.stance import HEIGHT_SIGMA_CELLS, ROLL_SIGMA_DEG
from recon.localisation.standpoints import Standpoint, Standpoints, orbited
from recon.records import FitFailure, PoseEstimate

MIN_SHOWN_PX = 60
"""Fewer pixels that show a thing say nothing."""
MIN_EXPLAINED, MIN_PROBABILITY, MAX_SIGMA_CELLS = 0.7, 0.99, 0.12
"""Of an accepted pose: share of the pixels that the map explains, probability, and standard
deviation of the position."""
SHARED = 1.5
"""Errors over their standard deviations, were those of neighbouring pixels and corners
independent."""
FIRST_CELLS, FIRST_RAD = 0.05, 0.003
"""First steps by which the precision is measured."""
REPEATS_DEG, NEARBY_DEG = (180.0, 120.0, 240.0, 90.0, 270.0), (-4.0, -2.0, 0.0, 2.0, 4.0)
"""Turns after which a texture that goes two to four times around looks the same, and turns near
them that are tried."""
BLUR_PER_PX = 0.5
"""Log likelihood a pixel by which a side painted from afar may differ from what it repeats: .24 at
a wrong pose that had no other doubt; other turned rivals lose .85 and more."""
REPEATS_PX = 2
"""Side of the pixels in which they are compared."""
LEAST_INFORMATION = 0.02
"""Of changes together, relative to each alone: less is not measured exactly."""
DROPS, MOST_STEPS = (0.5, 2.0), 12
"""Loss of log probability after a step by which the precision is measured."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Posterior:
    """The poses of a pair in a portrait, around the likeliest one."""

    portrait: Portrait
    look: Look
    best: Standpoint
    num_shown: int
    num_explained: int

    @classmethod
    def of(cls, portrait: Portrait, look: Look, best: Standpoint) -> "Posterior":
        """The posterior around the likeliest pose."""
        shown, explained = look.explained(portrait.solids, portrait.paint, best.T_world_left)
        return cls(
            portrait=portrait, look=look, best=best, num_shown=shown, num_explained=explained
        )

    def covariance(self, own: Array) -> Array:
        """Covariance (6, 6), in the order of `PoseEstimate`; `own` is that of the map."""
        ways = self._ways()
        scaled = ways * np.array([self._sigma(way) for way in ways])[:, None]
        together = np.linalg.inv(self._together(scaled))
        height = (HEIGHT_SIGMA_CELLS * self.portrait.cell_size) ** 2
        roll = math.radians(ROLL_SIGMA_DEG) ** 2
        still = np.diag([roll, 0.0, roll, 0.0, height, 0.0]) + self._by_solids()
        return np.asarray(scaled.T @ together @ scaled + still + own, np.float64)

    def _by_solids(self) -> Array:
        """Covariance (6, 6) from errors of the solids in view: of their places and sizes.

        What is so many times its size away is off by as many times that. Each tells how far away
        it is, and in which direction; the nearest also from which side.
        """
        T, information = self.best.T_world_left, np.zeros((3, 3))
        for thing in self._in_view():
            offset = (self.portrait.centre(thing) - T[:3, 3])[[0, 2]]
            away = float(np.linalg.norm(offset))
            ahead = offset / away
            aside = np.array([ahead[1], -ahead[0]])
            sizes = away / self.portrait.size(thing)
            # In the order turn about y, x, z.
            rows = [np.array([0.0, *ahead]) / sizes, np.array([away, *aside])]
            if thing == self.best.thing:
                rows.append(np.array([0.0, *aside]) / sizes)
            weight = self.portrait.precision(thing) ** -2.0
            information += weight * sum(np.outer(row, row) for row in rows)
        found = np.zeros((6, 6))
        found[np.ix_([1, 3, 5], [1, 3, 5])] = np.linalg.inv(information)
        return found

    def _in_view(self) -> list[int]:
        """Numbers of the objects that are seen well."""
        drawn, _ = self.look.densities(
            self.portrait.solids, self.portrait.paint, self.best.T_world_left, 1
        )
        numbers = self.portrait.thing[drawn.solid[drawn.solid >= 0]]
        seen = set(np.flatnonzero(np.bincount(numbers, minlength=1) >= MIN_SHOWN_PX).tolist())
        return sorted(seen | {self.best.thing})

    def _ways(self) -> Array:
        """Small changes (4, 6): ahead, around itself, up, and around the thing."""
        T, centre = self.best.T_world_left, self.portrait.centre(self.best.thing)
        ahead, offset = T[:3, 2] * [1.0, 0.0, 1.0], T[:3, 3] - centre
        ways = np.zeros((4, 6))
        ways[0, 3:] = FIRST_CELLS * self.portrait.cell_size * ahead / np.linalg.norm(ahead)
        ways[1, 1], ways[2, :3] = FIRST_RAD, FIRST_RAD * T[:3, 0]
        ways[3, 1] = FIRST_RAD
        ways[3, 3:] = FIRST_RAD * np.cross(WORLD_UP, offset)
        return ways

    def _sigma(self, way: Array) -> float:
        """Standard deviation along a change, as a multiple of it."""
        factor = 1.0
        for _ in range(MOST_STEPS):
            drop = self._drop(factor * way)
            if DROPS[0] <= drop <= DROPS[1]:
                break
            factor *= 1.5 if drop < DROPS[0] else 0.6
        return factor / math.sqrt(2.0 * max(drop, DROPS[0]))

    def _together(self, scaled: Array) -> Array:
        """Information (4, 4) of changes by one standard deviation each.

        Where two things are seen far away, one change undoes most of what another does.
        """
        found = np.eye(len(scaled))
        for row, column in zip(*np.triu_indices(len(scaled), 1), strict=True):
            one, other = scaled[row], scaled[column]
            both = (self._drop(one + other) - self._drop(one - other)) / 2.0
            found[row, column] = found[column, row] = both
        value, vector = np.linalg.eigh(found)
        return np.asarray((vector * np.maximum(value, LEAST_INFORMATION)) @ vector.T, np.float64)

    def _drop(self, change: Array) -> float:
        """Mean loss of log probability after a change either way."""
        poses = [moved(self.best.T_world_left, way) for way in (change, -change)]
        value = self.look.values(self.portrait.solids, self.portrait.paint, poses, 1)
        return float(self.best.value - value.mean()) / per_e(self.num_shown)

    def may_repeat(self) -> bool:
        """True if a texture that goes several times around may show the same elsewhere.

        A side that no pair has shown may be the one that is seen.
        """
        best = self.best.T_world_left
        centre = self.portrait.centre(self.best.thing)
        turns = np.radians(np.add.outer(REPEATS_DEG, NEARBY_DEG)).ravel().tolist()
        poses = [orbited(best, centre, turn) for turn in turns]
        odds = Odds(portrait=self.portrait, look=self.look)
        lost = odds.between(best, poses, self.portrait.hoped, REPEATS_PX)
        return bool(lost.min() < -math.log(1.0 - MIN_PROBABILITY))

    def is_turned(self, rival: Standpoint) -> bool:
        """True if a rival is the best pose after such a turn, and the textures hardly differ.

        What a texture repeats is painted more sharply on the side that was seen from nearer.
        """
        if self.best.value - rival.value > BLUR_PER_PX * self.num_shown:
            return False
        centre = self.portrait.centre(self.best.thing)
        return any(
            not replace(self.best, T_world_left=turned).is_apart(
                rival, APART_CELLS * self.portrait.cell_size, APART_RAD
            )
            for turned in (
                orbited(self.best.T_world_left, centre, math.radians(turn)) for turn in REPEATS_DEG
            )
        )


def decide(standpoints: Standpoints, corners: Corners, look: Look) -> PoseEstimate | FitFailure:
    """The pose of a pair by a portrait; a failure if it does not determine it."""
    portrait = standpoints.portrait
    pitch = standpoints.pitch(look)
    if look.against(portrait.paint, pitch)[1] < MIN_SHOWN_PX:
        return FitFailure("too little is seen")
    found = standpoints.of(look, pitch)
    found, probability = Odds(portrait=portrait, look=look).best_first(found)
    best = found[0]
    posterior = Posterior.of(portrait, look, best)
    if posterior.num_shown < MIN_SHOWN_PX:
        return FitFailure("too little is seen")
    if posterior.num_explained < MIN_EXPLAINED * posterior.num_shown:
        return FitFailure("the map shows other things there")
    is_repeated = posterior.may_repeat() or any(map(posterior.is_turned, found[1:]))
    if probability < MIN_PROBABILITY or is_repeated:
        return FitFailure("several places look like it")
    estimate = PoseEstimate(
        T_world_left=best.T_world_left,
        covariance=posterior.covariance(corners.own),
        probability=probability,
        residual=1.0,
        inlier_share=posterior.num_explained / posterior.num_shown,
        num_cells=posterior.num_shown,
    )
    estimate = corners.refined(look.pair, estimate)
    estimate = replace(estimate, covariance=SHARED**2 * estimate.covariance)
    return exact(estimate, MAX_SIGMA_CELLS * portrait.cell_size)
