"""Places: compact descriptions of pairs for visual place recognition.

Blobs of the left image with descriptors (SIFT, Lowe 2004) and disparities, which make them 3D
points. Images are also searched stretched and compressed horizontally, like upright surfaces seen
from other directions.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.records import StereoPair
from recon.sequences.odometry.motion import agreeing_tracks, refine_motion
from recon.sequences.odometry.tracking import Sightings, Tracks, seen_by_both
from recon.sequences.pair_images import grey

Array = NDArray[np.float64]

NUM_POINTS = 250
CONTRAST = 0.02
"""Contrast threshold of SIFT."""
DOUBLED_PX = 0.25
"""SIFT doubles the image first, which moves pixel centres by half a pixel of the doubled one: its
points are so far right of and below where they are, and the farther off the closer one comes."""
STRETCHES = (1.0, 0.65, 1.5)
"""Horizontal scales at which a place is searched for; it is stored at the first."""
NUM_BITS = 11
"""Number of bits of a descriptor's word."""
MIN_TRACKS = 12
"""Minimum number of points that agree on one motion."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Place:
    """Points of a pair with their descriptors."""

    rig: StereoRig
    sightings: Sightings
    descriptors: NDArray[np.uint8]
    """(N, 128)"""

    def __len__(self) -> int:
        return len(self.descriptors)

    @property
    def depth(self) -> float:
        """Median depth of the points, world units."""
        return float(np.median(self.rig.depth(self.sightings.disparity_px)))

    @property
    def summary(self) -> Array:
        """(W,) word histogram of unit length: similar for places that look similar."""
        return summary_of(self.descriptors)


def summary_of(descriptors: NDArray[np.uint8]) -> Array:
    """(W,) word histogram of descriptors (N, 128), of unit length."""
    count = np.bincount(_words(descriptors), minlength=2**NUM_BITS).astype(np.float64)
    summary: Array = np.sqrt(count / max(1.0, count.sum()))
    return summary


def see(pair: StereoPair, stretches: tuple[float, ...] = STRETCHES[:1]) -> Place:
    """The place that a pair shows.

    Parameters
    ----------
    stretches : tuple of float
        Horizontal scale factors of the image; the points of all of them are kept.
    """
    left, right = grey(pair.left), grey(pair.right)
    found = [blobs(left, stretch) for stretch in stretches]
    points = np.concatenate([points for points, _ in found])
    sightings, is_seen = seen_by_both(left, right, points)
    is_seen &= sightings.disparity_px > pair.rig.disparity_offset_px
    return Place(
        rig=pair.rig,
        sightings=sightings.select(is_seen),
        descriptors=np.concatenate([descriptors for _, descriptors in found])[is_seen],
    )


def blobs(
    image: NDArray[np.uint8], stretch: float = 1.0, number: int = NUM_POINTS
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Points (N, 2) of a horizontally scaled grey image, at most so many, with descriptors."""
    wide = image
    if stretch != 1.0:
        wide = cv2.resize(image, None, fx=stretch, fy=1.0, interpolation=cv2.INTER_AREA)
    points, descriptors = _sift(number).detectAndCompute(wide, None)
    if not points:
        return np.zeros((0, 2), np.float32), np.zeros((0, 128), np.uint8)
    places = np.array([point.pt for point in points], np.float32) - DOUBLED_PX
    scale = image.shape[1] / wide.shape[1]
    places[:, 0] = (places[:, 0] + 0.5) * scale - 0.5
    return places, descriptors.astype(np.uint8)


@cache
def _sift(number: int) -> Any:
    # Missing in OpenCV's type stubs.
    create: Any = cv2.SIFT_create  # type: ignore[attr-defined,unused-ignore]
    return create(nfeatures=number, contrastThreshold=CONTRAST, sigma=1.2)


def _words(descriptors: NDArray[np.uint8]) -> NDArray[np.int64]:
    """(N,) words: bits for the side of fixed random planes on which each descriptor lies."""
    rooted = np.sqrt(descriptors.astype(np.float64))
    rooted -= rooted.mean(axis=1, keepdims=True)
    words: NDArray[np.int64] = (rooted @ _planes() > 0) @ (1 << np.arange(NUM_BITS))
    return words


@cache
def _planes() -> Array:
    return np.random.default_rng(0).normal(size=(128, NUM_BITS))


def shared(first: Place, second: Place) -> Tracks:
    """The common points of two places, converted to the rig of the second."""
    if not (len(first) and len(second)):
        none = np.zeros(0, np.intp)
        return Tracks(first=first.sightings.select(none), second=second.sightings.select(none))
    pairs = cv2.BFMatcher(cv2.NORM_L2, crossCheck=True).match(
        first.descriptors.astype(np.float32), second.descriptors.astype(np.float32)
    )
    rows = np.array([(pair.queryIdx, pair.trainIdx) for pair in pairs], np.intp).reshape(-1, 2)
    return Tracks(
        first=as_seen_by(second.rig, first.sightings.select(rows[:, 0]), first.rig),
        second=second.sightings.select(rows[:, 1]),
    )


def as_seen_by(rig: StereoRig, seen: Sightings, by: StereoRig) -> Sightings:
    """Sightings of one rig, converted to another at the same pose."""
    zoom = rig.focal_px / by.focal_px
    own, other = (np.array([one.cx_left_px, one.cy_px]) for one in (rig, by))
    shift = (seen.disparity_px - by.disparity_offset_px) * (rig.baseline / by.baseline)
    return replace(
        seen,
        points_px=(seen.points_px - other) * zoom + own,
        disparity_px=shift * zoom + rig.disparity_offset_px,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Meeting:
    """The motion between two places that show the same scene."""

    T_second_first: Array
    """(4, 4) of the left cameras."""
    num_agreeing: int
    """Number of points that agree on it."""
    share: float
    """Share of the matched points that agree."""
    tracks: Tracks
    """The agreeing points, converted to the second rig."""


def meet(first: Place, second: Place) -> Meeting | None:
    """The motion between two places; None if too few points agree on one."""
    tracks = shared(first, second)
    agreeing = agreeing_tracks(tracks, second.rig)
    if agreeing is None:
        return None
    T_second_first, rows = agreeing
    kept = tracks.select(rows)
    refined = refine_motion(T_second_first, kept, second.rig) if rows.sum() >= MIN_TRACKS else None
    if refined is None:
        return None
    return Meeting(
        T_second_first=refined, num_agreeing=len(kept), share=len(kept) / len(tracks), tracks=kept
    )
