"""Correspondences of two images without assumptions about range, sides or rows."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.sequences.depth import Image
from recon.sequences.odometry.tracking import Sightings, corners, follow
from recon.sequences.pair_images import grey, levelled

Points = NDArray[np.float32]

MAX_WIDTH_PX = 320
"""Width of the images in which patches are searched."""
NUM_CORNERS = 120
PATCH_PX = 11
MAX_ROWS_PX = 10
"""Vertical search range of a patch, in the small image."""
MIN_SCORE = 0.85
"""Minimum normalised correlation of a match."""
MIN_LEAD = 0.05
"""Minimum lead over the second-best position: repetitive patches are uninformative."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Survey:
    """Corners of one image searched for in another."""

    seen: Sightings
    """Corners with one unambiguous match."""
    num_wanted: int
    """Corners searched for."""
    num_alike: int
    """Corners that match in one place or more."""


def survey(left: Image, right: Image) -> Survey:
    """Corners of the left image matched in the right one.

    Patches are searched along whole rows, and some rows above and below, in small images; unique
    matches are tracked at full size.
    """
    one = grey(left)
    other = levelled(grey(right), one)
    factor = max(1.0, one.shape[1] / MAX_WIDTH_PX)
    small, small_other = (_shrunk(image, factor) for image in (one, other))
    wanted = _spread(corners(small))
    starts, ends, num_alike = _found(small, small_other, wanted)
    points = ((starts + 0.5) * factor - 0.5).astype(np.float32)
    guess = ((ends + 0.5) * factor - 0.5).astype(np.float32)
    moved, is_found = follow(one, other, points, guess)
    offset = (points - moved).astype(np.float64)
    seen = Sightings(
        points_px=points.astype(np.float64), disparity_px=offset[:, 0], row_offset_px=-offset[:, 1]
    )
    return Survey(seen=seen.select(is_found), num_wanted=len(wanted), num_alike=num_alike)


def _shrunk(image: Image, factor: float) -> Image:
    if factor == 1.0:
        return image
    height, width = (max(1, round(extent / factor)) for extent in image.shape)
    small: Image = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
    return small


def _spread(points: Points) -> Points:
    """A subset of the points, from all over the image."""
    return points[:: max(1, len(points) // NUM_CORNERS)]


def _found(image: Image, other: Image, points: Points) -> tuple[Points, Points, int]:
    """The points with one unambiguous match, its positions, and the number with any match."""
    starts, ends, num_alike = [], [], 0
    for point in np.rint(points):
        place, score, lead = _place(image, other, point.astype(np.int64))
        num_alike += score >= MIN_SCORE
        if score >= MIN_SCORE and lead >= MIN_LEAD:
            starts.append(point)
            ends.append(place)
    shape = (-1, 2)
    return (
        np.array(starts, np.float32).reshape(shape),
        np.array(ends, np.float32).reshape(shape),
        num_alike,
    )


def _place(
    image: Image, other: Image, point: NDArray[np.int64]
) -> tuple[tuple[float, float], float, float]:
    """The position of the patch around a point, its score, and its lead over the next best."""
    half = PATCH_PX // 2
    u, v = int(point[0]), int(point[1])
    patch = image[v - half : v + half + 1, u - half : u + half + 1] if min(u, v) >= half else None
    if patch is None or patch.shape != (PATCH_PX, PATCH_PX):
        return (0.0, 0.0), 0.0, 0.0
    top = max(0, v - half - MAX_ROWS_PX)
    strip = other[top : v + half + 1 + MAX_ROWS_PX]
    scores = cv2.matchTemplate(strip, patch, cv2.TM_CCOEFF_NORMED)
    _, best, _, (column, row) = cv2.minMaxLoc(scores)
    around = (
        slice(max(0, row - half), row + half + 1),
        slice(max(0, column - half), column + half + 1),
    )
    scores[around] = -1.0
    return (float(column + half), float(top + row + half)), best, best - float(scores.max())
