"""Corners tracked from the left image to the right one and into the next pair."""

from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.geometry import transform
from recon.records import StereoPair
from recon.sequences.depth import Image
from recon.sequences.pair_images import grey, levelled

Array = NDArray[np.float64]
Rows = NDArray[np.bool_] | NDArray[np.integer]

NUM_CORNERS, NUM_CELLS = 700, 70
"""Corners are detected per cell, so that one textured wall does not get all of them."""
MIN_CORNER_SPACING_PX = 7
CORNER_QUALITY = 0.01
LK_WINDOW_PX, LK_LEVELS = 15, 4
GUIDED_LEVELS = 1
"""Pyramid levels for predicted corners; few, so that similar corners are not found."""
MAX_RETURN_ERROR_PX = 0.5
"""Maximum error of forward-backward tracking."""
MIN_SHIFT_PX = 1.0
"""Minimum disparity relative to infinity; farther points do not constrain the translation."""
MAX_ROW_ERROR_PX = 2.0
"""Between left and right image, relative to the median row offset."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sightings:
    """Points seen by both cameras at one time."""

    points_px: Array
    """(N, 2) in the left image."""
    disparity_px: Array
    """(N,) u_left - u_right."""
    row_offset_px: Array
    """(N,) v_right - v_left."""

    def __len__(self) -> int:
        return len(self.points_px)

    @property
    def right_points_px(self) -> Array:
        """(N, 2) in the right image."""
        points: Array = self.points_px + np.column_stack([-self.disparity_px, self.row_offset_px])
        return points

    def select(self, rows: Rows) -> "Sightings":
        """The sightings of `rows`."""
        return Sightings(**{name: getattr(self, name)[rows] for name in Sightings.__slots__})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tracks:
    """The same N points in two pairs."""

    first: Sightings
    second: Sightings

    def __len__(self) -> int:
        return len(self.first)

    def select(self, rows: Rows) -> "Tracks":
        """The tracks of `rows`."""
        return Tracks(first=self.first.select(rows), second=self.second.select(rows))


def track(
    first: StereoPair,
    second: StereoPair,
    T_second_first: Array | None = None,
    num_corners: int = NUM_CORNERS,
) -> Tracks:
    """Track corners of `first` through all four images.

    Parameters
    ----------
    first, second : StereoPair
    T_second_first : (4, 4), optional
        Motion of the left camera, to predict the corners; by default they start where they were.
    num_corners : int
        Approximate number of corners to track, which takes nearly all of the time.
    """
    left, next_left = grey(first.left), grey(second.left)
    right, next_right = levelled(grey(first.right), left), levelled(grey(second.right), next_left)
    points = corners(left, num_corners)
    seen, is_seen = seen_by_both(left, right, points)
    seen = seen.select(is_seen)
    if T_second_first is None:
        moved, is_moved = follow(left, next_left, points[is_seen])
    else:
        guess = _predicted(seen, first.rig, T_second_first)
        moved, is_moved = follow(left, next_left, points[is_seen], guess, GUIDED_LEVELS)
    next_seen, is_next_seen = seen_by_both(next_left, next_right, moved[is_moved])
    return Tracks(
        first=seen.select(is_moved).select(is_next_seen),
        second=next_seen.select(is_next_seen),
    )


def likeness(first: StereoPair, second: StereoPair, tracks: Tracks) -> Array:
    """(N,) correlation of what is around the tracked points in both left images.

    Tracking finds something near a predicted point even where both images show only noise.
    """
    left, next_left = grey(first.left), grey(second.left)
    found = [
        float((_window(left, there) * _window(next_left, then)).mean())
        for there, then in zip(tracks.first.points_px, tracks.second.points_px, strict=True)
    ]
    return np.array(found)


def _window(image: Image, point_px: Array) -> NDArray[np.float32]:
    """The window around a point, of mean 0 and standard deviation 1 but for rounding.

    The mean of each row is left out: along an edge that lies level, as the horizon, everything is
    alike, and a track slides.
    """
    size = (LK_WINDOW_PX, LK_WINDOW_PX)
    window = cv2.getRectSubPix(image, size, point_px.tolist(), patchType=cv2.CV_32F)
    off = window - window.mean(axis=1, keepdims=True)
    found: NDArray[np.float32] = off / max(float(off.std()), 1e-6)
    return found


def _predicted(seen: Sightings, rig: StereoRig, T_second_first: Array) -> NDArray[np.float32]:
    """(N, 2) predicted points after a motion; unchanged if it puts them behind the camera."""
    shift = seen.disparity_px - rig.disparity_offset_px
    places = seen.points_px.copy()
    near = shift > MIN_SHIFT_PX
    moved = transform(
        T_second_first, rig.triangulate(seen.points_px[near], seen.disparity_px[near])
    )
    rows = np.flatnonzero(near)[moved[:, 2] > 0]
    places[rows] = rig.project_left(moved[moved[:, 2] > 0])
    return places.astype(np.float32)


def sight(pair: StereoPair) -> Sightings:
    """Corners that both cameras see."""
    left = grey(pair.left)
    seen, is_seen = seen_by_both(left, levelled(grey(pair.right), left), corners(left))
    return seen.select(is_seen)


def corners(image: Image, number: int = NUM_CORNERS) -> NDArray[np.float32]:
    """(N, 2) corners, about `number` at most, spread over the image."""
    height, width = image.shape
    side = max(32.0, np.sqrt(width * height / NUM_CELLS))
    rows, columns = (max(1, round(extent / side)) for extent in (height, width))
    found = [np.zeros((0, 2), np.float32)]
    for top, bottom in _spans(height, rows):
        for start, end in _spans(width, columns):
            cell = cv2.goodFeaturesToTrack(
                image[top:bottom, start:end],
                number // (rows * columns) + 1,
                CORNER_QUALITY,
                MIN_CORNER_SPACING_PX,
            )
            if cell is not None:
                found.append(cell.reshape(-1, 2) + np.array([start, top], np.float32))
    return np.concatenate(found)


def _spans(extent: int, parts: int) -> list[tuple[int, int]]:
    return [*pairwise(round(part * extent / parts) for part in range(parts + 1))]


def seen_by_both(
    left: Image, right: Image, points: NDArray[np.float32]
) -> tuple[Sightings, NDArray[np.bool_]]:
    """Points (N, 2) of the left image as seen by both cameras, and the mask of those found."""
    found, is_found = follow(left, right, points)
    offset = points.astype(np.float64) - found
    row_offset = -offset[:, 1]
    usual = np.median(row_offset[is_found]) if is_found.any() else 0.0
    is_level = np.abs(row_offset - usual) < MAX_ROW_ERROR_PX
    seen = Sightings(
        points_px=points.astype(np.float64), disparity_px=offset[:, 0], row_offset_px=row_offset
    )
    return seen, is_found & is_level


def follow(
    source: Image,
    target: Image,
    points: NDArray[np.float32],
    guess: NDArray[np.float32] | None = None,
    num_levels: int = LK_LEVELS,
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Points (N, 2) tracked into another image, and the mask of those that track back.

    Parameters
    ----------
    source, target : (H, W) uint8
    points : (N, 2) float32
        In `source`.
    guess : (N, 2) float32, optional
        Approximate positions in `target`.
    num_levels : int
        Pyramid levels; more levels reach farther.
    """
    if not len(points):
        return points, np.zeros(0, np.bool_)
    step = partial(
        cv2.calcOpticalFlowPyrLK, winSize=(LK_WINDOW_PX, LK_WINDOW_PX), maxLevel=num_levels
    )
    if guess is None:
        there, ahead, _ = step(source, target, points, None)
        home, back, _ = step(target, source, there, None)
    else:
        known = {"flags": cv2.OPTFLOW_USE_INITIAL_FLOW}
        there, ahead, _ = step(source, target, points, guess.copy(), **known)
        home, back, _ = step(target, source, there, points.copy(), **known)
    error = np.linalg.norm(home - points, axis=1)
    return there, (ahead[:, 0] == 1) & (back[:, 0] == 1) & (error < MAX_RETURN_ERROR_PX)
