"""Inspection: the candidates of a search by the texture that a pair shows, if taken there."""

import math
from dataclasses import dataclass, replace

import numpy as np

from recon.camera import StereoRig
from recon.geometry import Array, invert, wrapped
from recon.localisation.candidates import CHANCE, Candidate, decide, distinct
from recon.localisation.graph import planar
from recon.localisation.place_errors import motion_covariance
from recon.localisation.registration import Points, Prior, inverse, moved
from recon.localisation.search import MIN_POINTS, Search
from recon.localisation.texture import Screen
from recon.localisation.turns import Turns
from recon.records import FitFailure, PoseEstimate, StereoPair
from recon.sequences.odometry.places import Meeting

NUM_MEASURED = 12
"""Turns that are measured, the likeliest ones."""
SHAPE_WEIGHT = 0.5
"""Weight of the evidence by shape, whose errors all sides of a round thing share."""
NUM_STARTS = 3
"""Candidates at one distance from one thing that are turned about it."""
MIN_TOLD = 3.0
"""Least evidence by texture of a pose that is measured."""
OTHER_SIDE_DEG, REPEATED_SHARE, MOST_REPEATED = 15.0, 0.6, 3.0
"""Turn to another side, the share of the best evidence by texture from which on that repeats the
texture, and the most that a texture says that repeats."""
SURE_LIKENESS = 0.8
"""Correlation from which on a side is not taken for one that has not been seen."""
MAX_OFF_SQ = 25.0
"""Squared standard deviations from which on two measurements contradict each other."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Inspection:
    """A search whose candidates are looked at closely."""

    search: Search
    turns: Turns
    own: Array
    """(6, 6) covariance of the pose of a pair of the run."""

    def recall(
        self, points: Points, pair: StereoPair, known: list[tuple[PoseEstimate, float]]
    ) -> PoseEstimate | FitFailure:
        """The pose of a pair from its points, its texture and known places."""
        if len(points) < MIN_POINTS:
            return FitFailure("too little is seen")
        found = self.candidates(points, pair, known)
        return decide(found, self.search.shape.size, SHAPE_WEIGHT * CHANCE)

    def candidates(
        self, points: Points, pair: StereoPair, known: list[tuple[PoseEstimate, float]]
    ) -> list[Candidate]:
        """The distinct poses that may be true, the likeliest first."""
        screen = Screen.of(points, pair.rig)
        found = self.search.candidates(points, pair.rig, known)
        judged = [*found, *self._measured(found, points, pair, screen)]
        poses = [one.estimate.T_world_left for one in judged]
        told = np.array([self.turns.texture.evidence(pair, screen, T) for T in poses])
        if len(told) and self._may_repeat(judged, told, pair, screen):
            told = np.minimum(told, MOST_REPEATED)
        both = [
            replace(one, evidence=SHAPE_WEIGHT * one.evidence + float(more))
            for one, more in zip(judged, told, strict=True)
        ]
        return distinct(both, self.search.shape.size)

    def _may_repeat(
        self, judged: list[Candidate], told: Array, pair: StereoPair, screen: Screen
    ) -> bool:
        """True if other sides, seen or not, or other things may have the texture of the pair."""
        best, poses = int(told.argmax()), [one.estimate.T_world_left for one in judged]
        thing = [self.turns.ahead(pair, T) for T in poses]
        headings = np.array([planar(T)[2] for T in poses])
        is_other = np.abs(wrapped(headings - headings[best])) > math.radians(OTHER_SIDE_DEG)
        is_other |= np.array([one != thing[best] for one in thing])
        if (told[is_other] > REPEATED_SHARE * told[best]).any():
            return True
        texture = self.turns.texture
        if thing[best] is not None and texture.is_whole[thing[best]]:
            return False
        shape = SHAPE_WEIGHT * np.array([one.evidence for one in judged])
        is_unlikely = shape.max() > shape[~is_other].max() + MOST_REPEATED
        return bool(is_unlikely) or texture.likeness(pair, screen, poses[best]) < SURE_LIKENESS

    def _measured(
        self, found: list[Candidate], points: Points, pair: StereoPair, screen: Screen
    ) -> list[Candidate]:
        """Poses where turns of candidates show the texture of the pair."""
        starts: list[tuple[float, Array]] = []
        for one in self._orbits(found, pair):
            poses = self.turns.around(pair, screen, one.estimate.T_world_left)
            starts += [
                (one.evidence + self.turns.texture.evidence(pair, screen, T), T) for T in poses
            ]
        starts.sort(key=lambda one: -one[0])
        met = [self.turns.measured(pair, T) for _, T in starts[:NUM_MEASURED]]
        estimates = [self._estimate(one, pair.rig) for one in met if one]
        texture = self.turns.texture
        return [
            self.search.judged(one, points, pair.rig, 0.0)
            for one in estimates
            if texture.evidence(pair, screen, one.T_world_left) > MIN_TOLD
        ]

    def _orbits(self, found: list[Candidate], pair: StereoPair) -> list[Candidate]:
        """Of the candidates at one distance from one thing, the likeliest ones."""
        kept: dict[tuple[int, int], list[Candidate]] = {}
        for one in found:
            T_world_left = one.estimate.T_world_left
            thing = self.turns.ahead(pair, T_world_left)
            if thing is not None:
                away = (self.turns.centre(thing) - T_world_left[:3, 3])[[0, 2]]
                orbit = (thing, round(np.hypot(*away) / self.search.shape.size))
                kept.setdefault(orbit, []).append(one)
        return [one for orbit in kept.values() for one in orbit[:NUM_STARTS]]

    def _estimate(self, met: list[tuple[Array, Meeting]], rig: StereoRig) -> PoseEstimate:
        """The pose by all pairs that agree with the one with most common points."""
        estimates = [measured_from(*one, rig, self.own) for one in met]
        best = estimates.pop(int(np.argmax([one.num_agreeing for _, one in met])))
        for other in estimates:
            best = _united(best, other)
        return self.search.upright(best)


def _united(one: PoseEstimate, other: PoseEstimate) -> PoseEstimate:
    """The mean of two estimates by their information; the first if they contradict each other."""
    known, more = inverse(one.covariance), inverse(other.covariance)
    off = Prior(T_world_left=one.T_world_left, information=known).pull(other.T_world_left)
    if off @ inverse(one.covariance + other.covariance) @ off > MAX_OFF_SQ:
        return one
    covariance = inverse(known + more)
    T_world_left = moved(one.T_world_left, covariance @ more @ off)
    return replace(one, T_world_left=T_world_left, covariance=covariance)


def measured_from(T_world_first: Array, met: Meeting, rig: StereoRig, own: Array) -> PoseEstimate:
    """The pose of a pair from a known one, with the uncertainty of the points and of that pose.

    Parameters
    ----------
    T_world_first : (4, 4) array
    met : Meeting
        Of the known pair with this one.
    rig : StereoRig
        Of this pair.
    own : (6, 6) array
        Covariance of the known pose.
    """
    T_world_left = T_world_first @ invert(met.T_second_first)
    turn = np.kron(np.eye(2), T_world_left[:3, :3])
    return PoseEstimate(
        T_world_left=T_world_left,
        covariance=turn @ motion_covariance(met, rig) @ turn.T + own,
        probability=0.0,
        residual=1.0,
        inlier_share=met.share,
        num_cells=0,
    )
