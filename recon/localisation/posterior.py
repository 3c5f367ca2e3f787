"""Posterior: how sure the likeliest standpoint is, and how precise.

A portrait is not perfect: its errors are those of whole surfaces, not of single pixels, so that the
number of pixels makes little surer. Log likelihoods count about as means over the pixels that show
something.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from recon.geometry import WORLD_UP, Array
from recon.localisation.candidates import exact
from recon.localisation.corners import Corners
from recon.localisation.look import Look
from recon.localisation.portrait import Portrait
from recon.localisation.registration import moved
from recon.localisation.stance import HEIGHT_SIGMA_CELLS, ROLL_SIGMA_DEG
from recon.localisation.standpoints import Standpoint, Standpoints, orbited
from recon.records import FitFailure, PoseEstimate

PER_E, OUTLINE_PER_E = 0.03, 1.6
"""Log likelihood that makes a pose e times as likely: so much for each pixel, as whole surfaces are
off, and for each side of a square of as many pixels, as outlines are. The true pose loses about .05
a pixel to the best one near it (27 pairs of four explorations)."""
MIN_SHOWN_PX = 60
"""Fewer pixels that show a thing say nothing."""
MIN_EXPLAINED, MIN_PROBABILITY, MAX_SIGMA_CELLS = 0.7, 0.99, 0.2
"""Of an accepted pose: share of the pixels that the map explains, probability, and standard
deviation of the position."""
SHARED = 1.5
"""Errors over their standard deviations, were those of neighbouring pixels and corners
independent."""
APART_CELLS, APART_RAD = 1.0, 0.1
"""Distance or turn from which on another pose is another place; nearer ones are an uncertainty."""
SOLID_CELLS = 0.03
"""Standard deviation of the place and size of a solid that is fitted to outlines: what is so many
times its size away is off by as many times that."""
FIRST_CELLS, FIRST_RAD = 0.05, 0.003
"""First steps by which the precision is measured."""
REPEATS_DEG, NEARBY_DEG = (180.0, 120.0, 240.0, 90.0, 270.0), (-4.0, -2.0, 0.0, 2.0, 4.0)
"""Turns after which a texture that goes two to four times around looks the same, and turns near
them that are tried."""
REPEATS_PX = 2
"""Side of the pixels in which they are compared."""
DROPS, MOST_STEPS = (0.5, 2.0), 12
"""Loss of log probability after a step by which the precision is measured."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Posterior:
    """The poses of a pair in a portrait."""

    portrait: Portrait
    look: Look
    num_shown: int
    num_explained: int

    @classmethod
    def of(cls, portrait: Portrait, look: Look, best: Standpoint) -> "Posterior":
        """The posterior around the likeliest pose."""
        shown, explained = look.explained(portrait.solids, portrait.paint, best.T_world_left)
        return cls(portrait=portrait, look=look, num_shown=shown, num_explained=explained)

    @property
    def per_e(self) -> float:
        """Log likelihood that makes a pose e times as likely."""
        return math.hypot(PER_E * self.num_shown, OUTLINE_PER_E * math.sqrt(self.num_shown))

    def probability(self, found: Sequence[Standpoint]) -> float:
        """Of the first pose, against those at other places."""
        length = APART_CELLS * self.portrait.cell_size
        others = [one for one in found[1:] if one.is_apart(found[0], length, APART_RAD)]
        evidence = np.array([one.value for one in (found[0], *others)]) / self.per_e
        return float(math.exp(evidence[0] - logsumexp(evidence)))

    def covariance(self, best: Standpoint, own: Array) -> Array:
        """Covariance (6, 6), in the order of `PoseEstimate`; `own` is that of the map."""
        ways = self._ways(best)
        sigmas = np.array([self._sigma(best, way) for way in ways])
        scaled = ways * sigmas[:, None]
        offset = best.T_world_left[:3, 3] - self.portrait.centre(best.thing)
        sizes = math.hypot(offset[0], offset[2]) / self.portrait.size(best.thing)
        place = (SOLID_CELLS * self.portrait.cell_size) ** 2 * (1.0 + sizes**2)
        height = (HEIGHT_SIGMA_CELLS * self.portrait.cell_size) ** 2
        roll = math.radians(ROLL_SIGMA_DEG) ** 2
        still = np.diag([roll, 0.0, roll, place, height, place])
        return np.asarray(scaled.T @ scaled + still + own, np.float64)

    def _ways(self, best: Standpoint) -> Array:
        """Small changes (4, 6): ahead, around itself, up, and around the thing.

        Their effects on an image are about independent.
        """
        T, centre = best.T_world_left, self.portrait.centre(best.thing)
        ahead, offset = T[:3, 2] * [1.0, 0.0, 1.0], T[:3, 3] - centre
        ways = np.zeros((4, 6))
        ways[0, 3:] = FIRST_CELLS * self.portrait.cell_size * ahead / np.linalg.norm(ahead)
        ways[1, 1], ways[2, :3] = FIRST_RAD, FIRST_RAD * T[:3, 0]
        ways[3, 1] = FIRST_RAD
        ways[3, 3:] = FIRST_RAD * np.cross(WORLD_UP, offset)
        return ways

    def _sigma(self, best: Standpoint, way: Array) -> float:
        """Standard deviation along a change, as a multiple of it."""
        factor = 1.0
        for _ in range(MOST_STEPS):
            drop = self._drop(best, factor * way)
            if DROPS[0] <= drop <= DROPS[1]:
                break
            factor *= 1.5 if drop < DROPS[0] else 0.6
        return factor / math.sqrt(2.0 * max(drop, DROPS[0]))

    def _drop(self, best: Standpoint, change: Array) -> float:
        """Mean loss of log probability after a change either way."""
        poses = [moved(best.T_world_left, way) for way in (change, -change)]
        value = self.look.values(self.portrait.solids, self.portrait.paint, poses, 1)
        return float(best.value - value.mean()) / self.per_e

    def may_repeat(self, best: Standpoint) -> bool:
        """True if a texture that goes several times around may show the same elsewhere.

        A side that no pair has shown may be the one that is seen.
        """
        centre = self.portrait.centre(best.thing)
        turns = np.radians(np.add.outer(REPEATS_DEG, NEARBY_DEG)).ravel().tolist()
        poses = [orbited(best.T_world_left, centre, turn) for turn in (0.0, *turns)]
        value = self.look.values(self.portrait.solids, self.portrait.hoped, poses, REPEATS_PX)
        lost = (value[0] - value[1:].max()) / self.per_e
        return bool(lost < -math.log(1.0 - MIN_PROBABILITY))


def decide(standpoints: Standpoints, corners: Corners, look: Look) -> PoseEstimate | FitFailure:
    """The pose of a pair by a portrait; a failure if it does not determine it."""
    portrait = standpoints.portrait
    pitch = standpoints.pitch(look)
    if look.against(portrait.paint, pitch)[1] < MIN_SHOWN_PX:
        return FitFailure("too little is seen")
    found = standpoints.of(look, pitch)
    best = found[0]
    posterior = Posterior.of(portrait, look, best)
    if posterior.num_shown < MIN_SHOWN_PX:
        return FitFailure("too little is seen")
    if posterior.num_explained < MIN_EXPLAINED * posterior.num_shown:
        return FitFailure("the map shows other things there")
    probability = posterior.probability(found)
    if probability < MIN_PROBABILITY or posterior.may_repeat(best):
        return FitFailure("several places look like it")
    estimate = PoseEstimate(
        T_world_left=best.T_world_left,
        covariance=posterior.covariance(best, corners.own),
        probability=probability,
        residual=1.0,
        inlier_share=posterior.num_explained / posterior.num_shown,
        num_cells=posterior.num_shown,
    )
    estimate = corners.refined(look.pair, estimate)
    estimate = replace(estimate, covariance=SHARED**2 * estimate.covariance)
    return exact(estimate, MAX_SIGMA_CELLS * portrait.cell_size)
