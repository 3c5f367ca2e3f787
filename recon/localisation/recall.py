"""Recall: the pose of a pair in a known map without a guess (the kidnapped robot problem)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from recon.geometry import invert
from recon.localisation.atlas import Atlas
from recon.localisation.candidates import (
    COVERED_COSINE,
    COVERED_SHARE,
    MAX_SIGMA_CELLS,
    exact,
    merged,
)
from recon.localisation.corners import Corners
from recon.localisation.locate import all_points, locate_points, points_of, prior_of
from recon.localisation.look import Look
from recon.localisation.outlook import Outlook
from recon.localisation.place_errors import PlaceErrors, measured_from
from recon.localisation.portrait import Portrait
from recon.localisation.posterior import decide
from recon.localisation.registration import Points, Prior
from recon.localisation.relocation import Relocation
from recon.localisation.search import Search
from recon.localisation.shapes import guesses
from recon.localisation.standpoints import Standpoints
from recon.localisation.surfels import Surfels
from recon.localisation.trust import MIN_AGREEING, trust_in
from recon.mapping.pair import match_points
from recon.records import FitFailure, FoundObject, PointCloud, PoseEstimate, StereoPair, Voxels
from recon.sequences.odometry.places import STRETCHES, Meeting, Place, meet, see
from recon.settings import Settings

Array = NDArray[np.float64]

NUM_CANDIDATES = 40
"""Number of most similar places that are compared with the pair point by point."""
NUM_HYPOTHESES = 12
TRUSTED_AGREEING = 2 * MIN_AGREEING
"""Points in agreement that are worth what features are trusted for."""
MIN_TRUST = 1.0
"""Trust in features above which a place that they show is believed before positions are
searched."""
NUM_SHAPES = 24
"""Number of guesses by shape that are refined."""
LEVEL_SIGMA_DEG, LEVEL_SIGMA_CELLS = 0.5, 0.1
"""Standard deviations of tilt and height of a guess by shape."""
TILES_PER_E = 1.5
"""Number of additional agreeing tiles that make a pose e times as likely; neighbouring tiles are
correlated."""
MIN_TILES = 6.0
"""Minimum number of agreeing minus disagreeing tiles; fewer may be chance."""
MIN_SHARE = 0.85
"""Minimum share of agreeing tiles at an accepted pose."""
MIN_PROBABILITY = 0.97


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Hypothesis:
    """A possible pose of a pair."""

    estimate: PoseEstimate
    num_same: int
    """Tiles of the image that agree with the map."""
    num_different: int
    num_agreeing: int = MIN_AGREEING
    """Points that agree with those of a place; 0 for a guess by shape, which only shows what else
    it may be."""

    @property
    def is_known(self) -> bool:
        """True if a place was recognised there."""
        return self.num_agreeing > 0

    @property
    def evidence(self) -> float:
        """Log likelihood ratio of the image against chance."""
        return (self.num_same - self.num_different - MIN_TILES) / TILES_PER_E

    def trusted(self, trust: float) -> float:
        """The evidence, including that of features as far as they are trusted."""
        return self.evidence + trust * self.num_agreeing / TRUSTED_AGREEING


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KnownWorld:
    """A map to localise pairs in."""

    voxels: Voxels
    surfels: Surfels
    atlas: Atlas
    summaries: Array
    """(P, W) summaries of the atlas's places."""
    depths: Array
    """(P,) median depths of the atlas's places, world units."""
    own: Array
    """(6, 6) covariance of the pose of a place."""
    trust: float
    """Logarithm of how often places that look alike are one place, over how often they are not."""
    settings: Settings
    objects: tuple[FoundObject, ...]
    search: Search | None
    """The search of all positions; None if the run's cameras do not stand level."""
    standpoints: Standpoints | None = None
    """The search by a portrait of the map's objects; None if its pairs are not at hand ..."""
    corners: Corners | None = None
    """... and the corners of those."""
    relocation: Relocation | None = None
    """The landmarks that its pairs show; None if they are not at hand."""

    @classmethod
    def of(
        cls,
        voxels: Voxels,
        atlas: Atlas,
        settings: Settings,
        objects: tuple[FoundObject, ...] = (),
    ) -> "KnownWorld":
        """A map, its places and its objects, ready to be searched."""
        return cls(
            voxels=voxels,
            surfels=Surfels.of(voxels),
            atlas=atlas,
            summaries=atlas.summaries,
            depths=atlas.depths,
            own=PlaceErrors.of(atlas, voxels.cell_size).covariance,
            trust=trust_in(atlas),
            settings=settings,
            objects=objects,
            search=Search.of(voxels, objects, atlas),
        )

    def painted(self, pairs: Sequence[StereoPair]) -> "KnownWorld":
        """The same with its landmarks and objects as pairs of the run, at its poses, show them."""
        known = replace(self, relocation=Relocation(pairs))
        if self.search is None or not self.objects:
            return known
        portrait = Portrait.of(self.objects, pairs, self.voxels.cell_size)
        if portrait is None:
            return known
        stance = self.search.stance
        corners = Corners(portrait=portrait, pairs=pairs, stance=stance, own=self.own)
        standpoints = Standpoints(portrait=portrait, stance=stance)
        return replace(known, standpoints=standpoints, corners=corners)

    def recall(self, pair: StereoPair) -> PoseEstimate | FitFailure:
        """The pose of a pair; a `FitFailure` if the map does not determine it."""
        found: PoseEstimate | FitFailure = FitFailure("no place looks like it")
        if self.search is None or self.trust > MIN_TRUST:
            found = choose(self.hypotheses(pair), self.trust)
            found = exact(found, MAX_SIGMA_CELLS * self.voxels.cell_size)
        if not found and self.standpoints is not None and self.corners is not None:
            found = decide(self.standpoints, self.corners, Look(pair=pair))
            if self.standpoints.portrait.is_whole:
                return found
        if not found and self.relocation is not None:
            found = self.relocation.recall(pair) or found
        if found or self.search is None:
            return found
        cloud = match_points(replace(pair, T_world_left=np.eye(4)), self.settings).cloud
        known = [
            (self.search.upright(one), self.trust * number / TRUSTED_AGREEING)
            for one, number in self._by_places(pair)
        ]
        return self.search.recall(all_points(cloud, pair.rig), pair.rig, known)

    def hypotheses(self, pair: StereoPair) -> list[Hypothesis]:
        """The distinct possible poses of a pair, the most likely first."""
        cloud = match_points(replace(pair, T_world_left=np.eye(4)), self.settings).cloud
        points = points_of(cloud, pair.rig, self.voxels.cell_size)
        outlook = Outlook.of(cloud, pair.rig)
        known = self._by_places(pair)
        guessed = [(one, 0) for one in self._by_shape(cloud, points, outlook)]
        found = [self._judged(one, number, outlook) for one, number in [*known, *guessed]]
        return distinct(found, self.voxels.cell_size)

    def _by_places(self, pair: StereoPair) -> list[tuple[PoseEstimate, int]]:
        """Poses by the places that look alike, with the number of points that agree, most first.

        They are not registered to the surface of the map, which is less precise than features.
        """
        if not len(self.atlas):
            return []
        query = see(pair, STRETCHES)
        likeness = self.summaries @ query.summary
        nearest = np.argsort(-likeness, kind="stable")[:NUM_CANDIDATES]
        met = [(int(row), meet(self.atlas.places[row], query)) for row in nearest]
        both = [(row, one) for row, one in met if one and one.num_agreeing >= MIN_AGREEING]
        both.sort(key=lambda one: -one[1].num_agreeing)
        return [
            (self._from(row, meeting, query), meeting.num_agreeing)
            for row, meeting in both[:NUM_HYPOTHESES]
        ]

    def _by_shape(self, cloud: PointCloud, points: Points, outlook: Outlook) -> list[PoseEstimate]:
        """Poses from the shape of what is seen, where no place covers them."""
        if not len(self.atlas):
            return []
        poses = guesses(cloud, self.voxels, self.atlas.T_world_left[0])
        seen = [outlook.agreement(self.voxels, T_world_left) for T_world_left in poses]
        best = np.argsort([different - same for same, different in seen], kind="stable")
        found = []
        for row in best[:NUM_SHAPES]:
            located = locate_points(points, self.surfels, self._level(poses[row]))
            if isinstance(located, PoseEstimate) and not self._is_covered(located.T_world_left):
                found.append(located)
        return found

    def _level(self, T_world_left: Array) -> Prior:
        """A guess by shape, at the height and tilt of all places."""
        loose = prior_of(T_world_left, self.voxels.cell_size).information
        tight = np.array([np.radians(LEVEL_SIGMA_DEG), LEVEL_SIGMA_CELLS * self.voxels.cell_size])
        information = loose.copy()
        information[[0, 2, 4], [0, 2, 4]] = tight[[0, 0, 1]] ** -2.0
        return Prior(T_world_left=T_world_left, information=information)

    def _is_covered(self, T_world_left: Array) -> bool:
        """True if a place shows what a pose would show."""
        apart = np.linalg.norm(self.atlas.T_world_left[:, :3, 3] - T_world_left[:3, 3], axis=1)
        alike = self.atlas.T_world_left[:, :3, 2] @ T_world_left[:3, 2]
        return bool(((apart < COVERED_SHARE * self.depths) & (alike > COVERED_COSINE)).any())

    def _from(self, row: int, meeting: Meeting, query: Place) -> PoseEstimate:
        """The pose of the query from a place."""
        return measured_from(self.atlas.T_world_left[row], meeting, query.rig, self.own)

    def _judged(self, estimate: PoseEstimate, num_agreeing: int, outlook: Outlook) -> Hypothesis:
        same, different = outlook.agreement(self.voxels, estimate.T_world_left)
        return Hypothesis(
            estimate=estimate, num_same=same, num_different=different, num_agreeing=num_agreeing
        )


def distinct(found: list[Hypothesis], cell_size: float) -> list[Hypothesis]:
    """The distinct hypotheses, the most likely first, by the place with the most common points."""
    return merged(found, lambda one, other: _is_same(one, other, cell_size), _by_more_points)


def _by_more_points(kept: Hypothesis, one: Hypothesis) -> Hypothesis:
    """A kept hypothesis, at the pose of a place with more common points."""
    if one.num_agreeing <= kept.num_agreeing:
        return kept
    return replace(kept, estimate=one.estimate, num_agreeing=one.num_agreeing)


def _is_same(one: Hypothesis, other: Hypothesis, cell_size: float) -> bool:
    a, b = one.estimate, other.estimate
    off = invert(a.T_world_left) @ b.T_world_left
    reach = max(cell_size, 3.0 * (a.sigma + b.sigma))
    return bool(np.linalg.norm(off[:3, 3]) < reach and np.trace(off[:3, :3]) > 1.0 + 2.0 * 0.98)


def choose(found: list[Hypothesis], trust: float = 0.0) -> PoseEstimate | FitFailure:
    """The likeliest of distinct hypotheses, likeliest first, if no other comes near it.

    Guesses by shape count as one, which is less likely the more features are trusted: a place
    never seen before that looks like a known one.
    """
    if not found:
        return FitFailure("no place looks like it")
    known = [one for one in found if one.is_known]
    known.sort(key=lambda one: -one.trusted(trust))
    best = known[0] if known else found[0]
    guessed = [one for one in found if not one.is_known][:1]
    # Chance is one more hypothesis, of evidence 0.
    evidence = np.array([*(one.trusted(trust) for one in [*known, *guessed]), 0.0])
    probability = float(np.exp(best.trusted(trust) - logsumexp(evidence)))
    if best.num_same < MIN_SHARE * (best.num_same + best.num_different):
        return FitFailure("the map shows other things there")
    if probability < MIN_PROBABILITY or not best.is_known:
        return FitFailure("several places look like it" if len(found) > 1 else "too little is seen")
    return replace(best.estimate, probability=probability)
