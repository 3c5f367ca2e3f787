"""Colours of points: at an outline, those of the side that has the point's disparity."""

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.records import Matches, StereoPair
from recon.stereo.features import to_grey
from recon.stereo.kernels.simd import Integers, kernel

Image = NDArray[np.uint8]
Window = NDArray[np.int32]
"""Grey levels, or parts, of the pixels of a window, row by row. Sums of integers are vectorised, as
their order does not matter."""

_WINDOW_SIDES = 3
"""Side of the square searched for an outline, relative to that of the colour window."""
_LARGEST_REACH_PX = 64
"""Larger sums of squares exceed 32 bits."""
_ROW_STEP = 2
"""Every second row of a window is enough, in half of the time."""
_NUM_SPLITS = 2
_FEWEST_PIXELS = 4
"""Fewer pixels of a part are no evidence."""
_PLAIN_VARIANCE = 4.0
"""Squared grey levels, of both images together: less texture is no evidence."""
_CLEAR_EVIDENCE = 0.2
"""Smallest evidence of a part, and smallest lead over the other part."""
_LESS_SHARE = 0.5
"""Largest evidence of the other part, relative to that of the surface."""
_BETWEEN = -1
"""Part of the pixels at the border of the two parts: they mix the colours of both."""
_SHARE_BITS = 8
_SHARES = 1 << _SHARE_BITS
"""Steps of the interpolation between two pixels."""
_CHANGES = (0, -_SHARES // 2, _SHARES // 2, -_SHARES, _SHARES)
"""Changes of the disparity, in such steps, that are tried until a part shows clear evidence: beside
the outline of a round thing, its texture lies nearer than the outline."""


def point_colours(
    matches: Matches, pair: StereoPair, is_sure: NDArray[np.bool_], side_px: int
) -> Image:
    """(M, 3) colours of matched points.

    An edge in the image is often the outline of a surface. The point is on the surface, but half of
    the pixels around it show what is behind. So the pixels around each sure point are divided into
    dark and bright ones. If one part has a texture that the other image shows at the point's
    disparity, and the other part has far less, the first is the surface, and its mean colour is the
    point's: a plain part, such as the sky, matches anywhere, and what is at another depth does not
    match. Otherwise, as within most surfaces, the colour is the mean of the square of `side_px`
    around the point.

    Parameters
    ----------
    matches : Matches
    pair : StereoPair
    is_sure : (M,)
        Points whose disparity is reliable.
    side_px : int
        Side of the square, which is clipped at the border.
    """
    left, right = (np.ascontiguousarray(image) for image in (pair.left, pair.right))
    u, v = np.rint(matches.points_px).astype(np.int64).T
    mean = cv2.blur(left, (side_px, side_px), borderType=cv2.BORDER_REPLICATE)
    colours = np.atleast_3d(mean)[v, u]
    reach = min(_WINDOW_SIDES * side_px // 2, _LARGEST_REACH_PX)
    rows = np.flatnonzero(is_sure)
    steps = np.rint(_SHARES * (u - matches.disparity_px)[rows]).astype(np.int64)
    # Changed disparities take a window one pixel further.
    is_inner = _is_inner(left.shape, reach + 1, u[rows], v[rows], steps // _SHARES)
    rows, steps = rows[is_inner], steps[is_inner]
    pixels = u[rows], v[rows], steps
    _take_surfaces(to_grey(left), to_grey(right), np.atleast_3d(left), pixels, rows, reach, colours)
    return np.ascontiguousarray(np.broadcast_to(colours, (len(matches), 3)))


def _is_inner(
    shape: tuple[int, ...], reach: int, u: Integers, v: Integers, u_right: Integers
) -> NDArray[np.bool_]:
    """Mask of the points whose windows lie in both images."""
    height, width = shape[:2]
    first, last = np.minimum(u, u_right), np.maximum(u, u_right)
    is_inner: NDArray[np.bool_] = (first >= reach) & (last < width - reach - 1)
    return is_inner & (v >= reach) & (v < height - reach)


@njit(cache=True, nogil=True, error_model="numpy")
def _take_surfaces(
    left: Image,
    right: Image,
    seen: Image,
    pixels: tuple[Integers, Integers, Integers],
    rows: Integers,
    reach: int,
    colours: Image,
) -> None:
    """Replace the colours of the points with one part of their window on their surface.

    The pixels are u, v in the left image, and `_SHARES` times u in the right one.
    """
    side = 2 * reach + 1
    size = (reach + 1) * side
    ours, theirs = np.empty(size, np.int32), np.empty(size, np.int32)
    is_bright, parts = np.empty(size, np.int32), np.empty(size, np.int32)
    for i in range(rows.size):
        top, first = pixels[1][i] - reach, pixels[0][i] - reach
        _copy(left, top, _SHARES * first, side, ours)
        _divide(ours, _middle(ours), side, is_bright, parts)
        dark = bright = 0.0
        for change in _CHANGES:
            _copy(right, top, pixels[2][i] - _SHARES * reach - change, side, theirs)
            dark = _evidence(ours, theirs, parts, side, 0)
            bright = _evidence(ours, theirs, parts, side, 1)
            if max(dark, bright) > _CLEAR_EVIDENCE:
                break
        more, less = max(dark, bright), min(dark, bright)
        if more > _CLEAR_EVIDENCE and less < _LESS_SHARE * more:
            _average(seen, top, first, parts, side, int(bright > dark), colours[rows[i]])


@kernel
def _copy(grey: Image, top: int, steps: int, side: int, window: Window) -> None:
    """Copy the window whose first column is at `steps / _SHARES`, interpolated along the row."""
    first, share = steps // _SHARES, np.int32(steps % _SHARES)
    for a in range(window.size // side):
        row = grey[top + _ROW_STEP * a, first : first + side + 1]
        copied = window[a * side : (a + 1) * side]
        for b in range(side):
            low, high = np.int32(row[b]), np.int32(row[b + 1])
            between = share * (high - low) + np.int32(_SHARES // 2)
            copied[b] = low + (between >> np.int32(_SHARE_BITS))


@kernel
def _middle(window: Window) -> np.integer:
    """The level midway between the means of the dark and the bright pixels."""
    total = np.int32(0)
    for level in window:
        total += level
    middle = total // window.size
    for _ in range(_NUM_SPLITS):
        limit = np.int32(middle)
        bright = num = np.int32(0)
        for level in window:
            is_bright = np.int32(level > limit)
            num += is_bright
            bright += is_bright * level
        if num in (0, window.size):
            break
        middle = (bright // num + (total - bright) // (window.size - num)) // 2
    return middle


@kernel
def _divide(
    window: Window, middle: np.integer, side: int, is_bright: Window, parts: Window
) -> None:
    """Write 0 for dark and 1 for bright pixels, `_BETWEEN` for those beside the other part."""
    limit = np.int32(middle)
    for i in range(window.size):
        is_bright[i] = np.int32(window[i] > limit)
        parts[i] = is_bright[i]
    for i in range(window.size - side):
        differ = is_bright[i] ^ is_bright[i + side]
        parts[i] |= -differ
        parts[i + side] |= -differ
    for a in range(window.size // side):
        own, label = is_bright[a * side : (a + 1) * side], parts[a * side : (a + 1) * side]
        for b in range(side - 1):
            differ = own[b] ^ own[b + 1]
            label[b] |= -differ
            label[b + 1] |= -differ


@kernel
def _evidence(ours: Window, theirs: Window, parts: Window, side: int, part: int) -> float:
    """Log ratio of a part's variances in both images to the variance of their difference.

    Positive if both images show the same texture; 0 if there is none. Variances are those along the
    rows, since other texture, such as a sky that darkens upwards, matches at any disparity.
    """
    total = 0
    texture = change = np.float64(0)
    for a in range(parts.size // side):
        row = slice(a * side, (a + 1) * side)
        num, mean, their_mean, square, product = _sums(ours[row], theirs[row], parts[row], part)
        total += num
        share = 1.0 / max(num, 1)
        texture += square - share * (float(mean) ** 2 + float(their_mean) ** 2)
        change += square - 2.0 * product - share * float(mean - their_mean) ** 2
    if total < _FEWEST_PIXELS:
        return 0.0
    plain = _PLAIN_VARIANCE * total
    return float(np.log((texture + plain) / (change + plain)))


@kernel
def _sums(ours: Window, theirs: Window, parts: Window, part: int) -> tuple[np.int32, ...]:
    """Number of a part's pixels, sums of their levels, of all squares and of the products."""
    label = np.int32(part)
    num = mean = their_mean = square = product = np.int32(0)
    for i in range(parts.size):
        own = np.int32(parts[i] == label)
        x, y = own * ours[i], own * theirs[i]
        num += own
        mean += x
        their_mean += y
        square += x * x + y * y
        product += x * y
    return num, mean, their_mean, square, product


@kernel
def _average(
    seen: Image, top: int, first: int, parts: Window, side: int, part: int, colour: Image
) -> None:
    """Write the mean colour of a part."""
    for c in range(colour.size):
        num = total = 0
        for a in range(parts.size // side):
            row = seen[top + _ROW_STEP * a, first : first + side, c]
            for b in range(side):
                own = int(parts[a * side + b] == part)
                num += own
                total += own * row[b]
        colour[c] = (total + num // 2) // num
