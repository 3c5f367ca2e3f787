"""Correspondences of two images that take nothing for granted: no range, no sides, no rows."""

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.sequences.depth import Image
from recon.sequences.odometry.tracking import Sightings, corners, follow
from recon.sequences.pair_images import grey

Points = NDArray[np.float32]

MAX_WIDTH_PX = 320
"""Of the images in which patches are looked for."""
NUM_CORNERS = 120
PATCH_PX = 11
MAX_ROWS_PX = 10
"""Up and down that a patch is looked for, in the small image."""
MIN_SCORE = 0.85
"""Normalised correlation of a patch that is found."""
MIN_LEAD = 0.05
"""Over the next best place elsewhere: patches that repeat tell nothing."""


def survey(left: Image, right: Image) -> tuple[Sightings, int]:
    """Corners of the left image wherever they are in the right one, and how many were looked for.

    Patches are looked for along whole rows and some rows above and below, in small images; those
    that are found once only are followed at full size.
    """
    one, other = grey(left), grey(right)
    factor = max(1.0, one.shape[1] / MAX_WIDTH_PX)
    small, small_other = (_shrunk(image, factor) for image in (one, other))
    wanted = _spread(corners(small))
    starts, ends = _found(small, small_other, wanted)
    points = ((starts + 0.5) * factor - 0.5).astype(np.float32)
    guess = ((ends + 0.5) * factor - 0.5).astype(np.float32)
    moved, is_found = follow(one, other, points, guess)
    offset = (points - moved).astype(np.float64)
    seen = Sightings(
        points_px=points.astype(np.float64), disparity_px=offset[:, 0], row_offset_px=-offset[:, 1]
    )
    return seen.select(is_found), len(wanted)


def _shrunk(image: Image, factor: float) -> Image:
    if factor == 1.0:
        return image
    height, width = (max(1, round(extent / factor)) for extent in image.shape)
    small: Image = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
    return small


def _spread(points: Points) -> Points:
    """Some of the points, from all over the image."""
    return points[:: max(1, len(points) // NUM_CORNERS)]


def _found(image: Image, other: Image, points: Points) -> tuple[Points, Points]:
    """The points whose patch is found, and where."""
    starts, ends = [], []
    for point in points:
        place = _place(image, other, np.rint(point).astype(np.int64))
        if place is not None:
            starts.append(np.rint(point))
            ends.append(place)
    shape = (-1, 2)
    return np.array(starts, np.float32).reshape(shape), np.array(ends, np.float32).reshape(shape)


def _place(image: Image, other: Image, point: NDArray[np.int64]) -> tuple[float, float] | None:
    half = PATCH_PX // 2
    u, v = int(point[0]), int(point[1])
    patch = image[v - half : v + half + 1, u - half : u + half + 1] if min(u, v) >= half else None
    if patch is None or patch.shape != (PATCH_PX, PATCH_PX):
        return None
    top = max(0, v - half - MAX_ROWS_PX)
    strip = other[top : v + half + 1 + MAX_ROWS_PX]
    scores = cv2.matchTemplate(strip, patch, cv2.TM_CCOEFF_NORMED)
    _, best, _, (column, row) = cv2.minMaxLoc(scores)
    around = (
        slice(max(0, row - half), row + half + 1),
        slice(max(0, column - half), column + half + 1),
    )
    scores[around] = -1.0
    if best < MIN_SCORE or best - scores.max() < MIN_LEAD:
        return None
    return float(column + half), float(top + row + half)
