"""Matching by the phase of all scales and orientations, supported by neighbours (Eqs 15 to 18)."""

import dataclasses
from collections.abc import Callable

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import Features, Matches
from recon.settings import MatchingSettings
from recon.stereo.exposure import gain_between
from recon.stereo.kernels.simd import Floats
from recon.stereo.kernels.sorting import falling
from recon.stereo.matching.aggregation import Points, Support, aggregate_rows
from recon.stereo.matching.cost import Responses
from recon.stereo.matching.search import C_COS, Search
from recon.stereo.matching.windows import SIDE_RADIUS

_RIVAL_WEIGHT = 0.3
"""Reduction of the confidence by an equally good rival disparity."""
_ODDS_OF_CONFIDENCE = 7.7
"""Slope of the log odds that a pair is correct, fitted to recorded pairs and rendered worlds."""
_EVEN_CONFIDENCE = 0.14
"""Confidence at which half of the pairs are correct."""
_DEAD_ZONE = 0.04
"""Difference of the sides' evidence above which a point is moved off its edge."""

_EVERY_IN_CHECK = 2
"""Only every second row supports the check. It needs no more: with all rows it takes twice as long
and confirms a hundredth more matches, of which a larger share is wrong."""

Rows = NDArray[np.int64]


def match(left: Features, right: Features, settings: MatchingSettings) -> Matches:
    """Mutually best pairs, moved to the side of their edge that has their disparity."""
    matches = match_by(left, right, settings, C_COS, _confidence)
    odds = _ODDS_OF_CONFIDENCE * (matches.score - _EVEN_CONFIDENCE)
    return dataclasses.replace(matches, probability=1.0 / (1.0 + np.exp(-odds)))


def _confidence(support: Support) -> Floats:
    """Support, reduced by that of a rival: repetition, or an edge along the row."""
    confidence: Floats = support.score - _RIVAL_WEIGHT * support.rival
    return confidence


def match_by(
    left: Features,
    right: Features,
    settings: MatchingSettings,
    table: Floats,
    confidence: Callable[[Support], Floats],
) -> Matches:
    """Match with the similarity of a table (see `Search`) and a custom confidence."""
    height, width = left.grey.shape
    lowest = max(settings.min_disparity, 1 - width)
    count = min(settings.max_disparity, width - 1) - lowest + 1
    if count < 1:
        raise InputError(
            f"disparities {settings.min_disparity}..{settings.max_disparity} all lie outside "
            f"the image, whose width is {width}"
        )
    every = {"half": 1, "quarter": 2}[settings.support_sampling]
    is_unique = settings.cross_check == "row"
    search = Search(1 - count - lowest, count, 0, every, is_unique, table)
    images = _responses(left), _responses(right, gain_between(left.grey, right.grey))
    points = _points(left.points_px.astype(np.int64), left.orientation_rad, height)
    support = aggregate_rows(*images, points, search, settings.max_row_offset_px)
    rows = np.flatnonzero(np.isfinite(support.score))
    if not is_unique:
        back = search._replace(first=lowest, every=_EVERY_IN_CHECK)
        rows = rows[_agrees(images, points, support, rows, (back, settings.max_row_offset_px))]
    return _ranked(right, points, support, confidence(support), rows)


def _agrees(
    images: tuple[Responses, Responses],
    points: Points,
    support: Support,
    rows: Rows,
    search: tuple[Search, int],
) -> NDArray[np.bool_]:
    """Mask of the pairs that the right pixel also chooses when matched to the left image."""
    left, right = images
    height, width = left.mask.shape
    partner = (points.v + support.row_shift) * width + points.u + support.shift
    is_partner = np.zeros(height * width, np.bool_)
    is_partner[partner[rows]] = True
    numbers = np.flatnonzero(is_partner)
    number = np.empty(height * width, np.int32)
    number[numbers] = np.arange(len(numbers), dtype=np.int32)
    pixels = np.column_stack([numbers % width, numbers // width])
    no_orientation = np.zeros(0, np.float32)
    back = aggregate_rows(right, left, _points(pixels, no_orientation, height), *search)
    place = number[partner[rows]]
    agrees: NDArray[np.bool_] = (back.shift[place] == -support.shift[rows]) & (
        back.row_shift[place] == -support.row_shift[rows]
    )
    return agrees


def _points(pixels: Rows, orientation: NDArray[np.float32], height: int) -> Points:
    return Points(
        u=np.ascontiguousarray(pixels[:, 0]),
        v=np.ascontiguousarray(pixels[:, 1]),
        orientation=orientation,
        starts=np.searchsorted(pixels[:, 1], np.arange(height + 1)),
    )


def _responses(features: Features, gain: float = 1.0) -> Responses:
    """An image in the layout of the loops, normalised to gain 1."""
    height, _, _, _, padded = features.planes.shape
    margin, edge = SIDE_RADIUS, cv2.BORDER_REPLICATE
    grey = cv2.copyMakeBorder(features.grey, margin, margin, margin, margin, edge)
    planes = features.planes.reshape(height, -1, 2, padded)
    return Responses(planes, np.float32(1.0 / gain), features.candidate_mask, grey.reshape(-1))


def _ranked(
    right: Features, points: Points, support: Support, confidence: Floats, rows: Rows
) -> Matches:
    """The pairs as matches, most confident first; of those at the same pixel only the first."""
    rows = rows[falling(confidence[rows])]
    pixels = np.empty((len(rows), 2))
    is_taken = np.zeros(right.grey.shape, np.bool_)
    step = (support.side > _DEAD_ZONE).astype(np.int64) - (support.side < -_DEAD_ZONE)
    num = _settle(points, (support.shift, step), rows, is_taken, pixels)
    rows, disparity = rows[:num], -support.shift[rows[:num]]
    return Matches(
        points_px=pixels[:num],
        disparity_px=disparity.astype(np.float64),
        sigma_px=np.full(num, np.nan),
        score=confidence[rows].astype(np.float64),
        index_left=rows.astype(np.int32),
        index_right=_rows_at(
            right.points_px, right.grey.shape, points.u[rows] - disparity,
            points.v[rows] + support.row_shift[rows],
        ),
    )  # fmt: skip


@njit(cache=True)
def _settle(
    points: Points,
    moves: tuple[Rows, Rows],
    rows: Rows,
    is_taken: NDArray[np.bool_],
    pixels: NDArray[np.float64],
) -> int:
    """Move pairs along their normals toward the side of the edge that has the disparity.

    `moves` are the points' shifts and their steps along the normal. The first pair at each pixel is
    kept, if it lies in both images: writes the rows and pixels of these to the front, and returns
    their number.
    """
    height, width = is_taken.shape
    shift, step = moves
    num = 0
    for i in rows:
        du, dv = _neighbour(points.orientation[i])
        u, v = points.u[i] + step[i] * du, points.v[i] + step[i] * dv
        inside = min(u, u + shift[i]) >= 0 and max(u, u + shift[i]) < width and 0 <= v < height
        if inside and not is_taken[v, u]:
            is_taken[v, u] = True
            rows[num], pixels[num, 0], pixels[num, 1] = i, u, v
            num += 1
    return num


@njit(cache=True)
def _neighbour(orientation: float) -> tuple[int, int]:
    """Step to the neighbour along a direction in [0, pi]: its cosine and sine, rounded."""
    third, sixth = np.pi / 3, np.pi / 6
    du = 1 if orientation < third else (-1 if orientation > 2 * third else 0)
    dv = 1 if sixth < orientation < 5 * sixth else 0
    return du, dv


@njit(cache=True)
def _rows_at(
    pixels: NDArray[np.float64], shape: tuple[int, int], u: Rows, v: Rows
) -> NDArray[np.int32]:
    """Rows of an image's features, which are at `pixels`, at other pixels; -1 = none."""
    row = np.full(shape, -1, np.int32)
    for k in range(len(pixels)):
        row[int(pixels[k, 1]), int(pixels[k, 0])] = k
    found = np.empty(len(u), np.int32)
    for k in range(len(u)):
        found[k] = row[v[k], u[k]]
    return found
