"""Corners: the pose of a pair, nearly known, by corners that it shares with pairs of the run.

An image of the run is drawn as it would look from there; corners tracked from the drawing into the
pair are points that both show, even if they see them from different sides.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from recon.camera import StereoRig
from recon.geometry import Array, invert, transform
from recon.localisation.cameras import camera_of
from recon.localisation.drawing import Indices, draw, texels
from recon.localisation.place_errors import measured_from
from recon.localisation.portrait import Portrait
from recon.localisation.registration import Prior, inverse, moved
from recon.localisation.stance import Stance
from recon.records import PoseEstimate, StereoPair
from recon.sequences.odometry.motion import MAX_SIGMAS, MIN_TRACKS, linearise, refine_motion
from recon.sequences.odometry.places import Meeting, as_seen_by
from recon.sequences.odometry.tracking import GUIDED_LEVELS, Tracks, follow, seen_by_both
from recon.sequences.pair_images import grey

NUM_SOURCES, SOURCE_PX = 2, 4
"""Pairs from which corners are tracked, and side of the pixels in which they are compared."""
NUM_CORNERS, CORNER_QUALITY, CORNER_SPACING_PX = 300, 0.01, 3
MARGIN_PX = 2
"""Width of the margin of what is drawn in which there are no corners."""
SAME_DEPTH = 0.03
"""Relative difference of depths up to which two images show the same piece of surface."""
MIN_SHARE = 0.5
"""Least share of the corners that agree on a motion."""
NUM_ROUNDS = 2
"""Number of times that an image is drawn at the pose found last."""
MAX_OFF_SQ = 25.0
"""Squared standard deviations from which on two measurements contradict each other."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Corners:
    """Pairs of a run and the portrait that they made."""

    portrait: Portrait
    pairs: Sequence[StereoPair]
    stance: Stance
    own: Array
    """(6, 6) covariance of the pose of a pair of the run."""

    def refined(self, pair: StereoPair, estimate: PoseEstimate) -> PoseEstimate:
        """A pose, by the corners of the pairs that agree with it if they are more precise."""
        for number in self._sources(pair, estimate.T_world_left):
            met = self._met(self.pairs[number], pair, estimate.T_world_left)
            if met is not None:
                T_first, meeting = met
                measured = measured_from(T_first, meeting, pair.rig, self.own)
                measured = self.stance.upright(measured, self.portrait.cell_size)
                if measured.sigma < estimate.sigma:
                    estimate = _united(estimate, measured)
        return estimate

    def _sources(self, pair: StereoPair, T_world_left: Array) -> list[int]:
        """Numbers of the pairs that show most of what is in view."""
        here = self._texels(pair.rig, T_world_left)
        number = np.array([self._shared(here, one) for one in self.pairs])
        best = np.argsort(-number, kind="stable")[:NUM_SOURCES]
        return [int(one) for one in best if number[one]]

    def _shared(self, texel: Indices, known: StereoPair) -> int:
        """Number of large pixels of a known pair that show some of the texels."""
        assert known.T_world_left is not None
        there = self._texels(known.rig, known.T_world_left)
        return int(np.isin(there[there >= 0], texel).sum())

    def _texels(self, rig: StereoRig, T_world_left: Array) -> Indices:
        """Texels that large pixels show."""
        solids, camera = self.portrait.solids, camera_of(T_world_left, rig)
        found: Indices = texels(solids, draw(solids, camera, SOURCE_PX), camera)
        return found

    def _met(
        self, known: StereoPair, pair: StereoPair, T_world_left: Array
    ) -> tuple[Array, Meeting] | None:
        """The pose of a known pair, and its meeting with one that is near a pose."""
        assert known.T_world_left is not None
        met = None
        for _ in range(NUM_ROUNDS):
            tracks = self._tracks(known, pair, T_world_left)
            met = _agreed(tracks, invert(T_world_left) @ known.T_world_left, pair)
            if met is None:
                return None
            T_world_left = known.T_world_left @ invert(met.T_second_first)
        return None if met is None else (known.T_world_left, met)

    def _tracks(self, known: StereoPair, pair: StereoPair, T_world_left: Array) -> Tracks:
        """Corners of a known pair, tracked from its image drawn from a pose into another pair."""
        source_px = self._drawn(known, pair, T_world_left)
        left, right = grey(pair.left), grey(pair.right)
        known_left, known_right = grey(known.left), grey(known.right)
        is_drawn = np.isfinite(source_px[..., 0])
        at = np.where(is_drawn[..., None], source_px, -1.0).astype(np.float32)
        drawn = cv2.remap(known_left, at[..., 0], at[..., 1], cv2.INTER_LINEAR)
        drawn = np.where(is_drawn, drawn, left)
        inner = cv2.erode(is_drawn.astype(np.uint8), np.ones((2 * MARGIN_PX + 1,) * 2, np.uint8))
        found = cv2.goodFeaturesToTrack(
            drawn, NUM_CORNERS, CORNER_QUALITY, CORNER_SPACING_PX, mask=inner
        )
        corners = np.zeros((0, 2), np.float32) if found is None else found.reshape(-1, 2)
        moved_px, is_moved = follow(drawn, left, corners, corners.copy(), GUIDED_LEVELS)
        column, row = np.rint(corners).astype(np.intp).T
        from_px = source_px[row, column].astype(np.float32)
        first, is_first = seen_by_both(known_left, known_right, from_px)
        second, is_second = seen_by_both(left, right, moved_px)
        both = is_moved & is_first & is_second
        return Tracks(
            first=as_seen_by(pair.rig, first.select(both), known.rig), second=second.select(both)
        )

    def _drawn(self, known: StereoPair, pair: StereoPair, T_world_left: Array) -> Array:
        """Points (H, W, 2) of a known image that show what each pixel of a pair does; else NaN."""
        assert known.T_world_left is not None
        here = draw(self.portrait.solids, camera_of(T_world_left, pair.rig), 1)
        there = draw(self.portrait.solids, camera_of(known.T_world_left, known.rig), 1)
        row, column = np.nonzero(here.solid >= 0)
        rays = pair.rig.rays(np.column_stack([column, row]).astype(np.float64))
        surface = transform(T_world_left, rays * here.depth[row, column, None])
        back = transform(invert(known.T_world_left), surface)
        ahead = back[:, 2] > 0.0
        row, column, back = row[ahead], column[ahead], back[ahead]
        from_px = known.rig.project_left(back)
        size = np.array([known.rig.width, known.rig.height])
        nearest = np.clip(np.rint(from_px), 0, size - 1).astype(np.intp)
        depth = there.depth[nearest[:, 1], nearest[:, 0]]
        shown = ((from_px >= 0) & (from_px <= size - 1)).all(axis=1)
        shown &= np.abs(depth - back[:, 2]) < SAME_DEPTH * back[:, 2]
        drawn = np.full((pair.rig.height, pair.rig.width, 2), np.nan)
        drawn[row[shown], column[shown]] = from_px[shown]
        return drawn


def _agreed(tracks: Tracks, start: Array, pair: StereoPair) -> Meeting | None:
    """The motion on which enough tracks agree."""
    if len(tracks) < MIN_TRACKS:
        return None
    refined = refine_motion(start, tracks, pair.rig)
    if refined is None:
        return None
    agree = linearise(refined, tracks, pair.rig).distances < MAX_SIGMAS
    if agree.sum() < max(MIN_TRACKS, MIN_SHARE * len(tracks)):
        return None
    kept = tracks.select(agree)
    refined = refine_motion(refined, kept, pair.rig)
    if refined is None:
        return None
    return Meeting(
        T_second_first=refined, num_agreeing=len(kept), share=len(kept) / len(tracks), tracks=kept
    )


def _united(one: PoseEstimate, other: PoseEstimate) -> PoseEstimate:
    """The mean of two estimates by their information; the first if they contradict each other."""
    known, more = inverse(one.covariance), inverse(other.covariance)
    off = Prior(T_world_left=one.T_world_left, information=known).pull(other.T_world_left)
    if off @ inverse(one.covariance + other.covariance) @ off > MAX_OFF_SQ:
        return one
    covariance = inverse(known + more)
    T_world_left = moved(one.T_world_left, covariance @ more @ off)
    return replace(one, T_world_left=T_world_left, covariance=covariance)
