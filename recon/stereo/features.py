"""Feature points: ridges of the steerable filters' response (thesis 3.3)."""

from functools import partial

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import Features
from recon.settings import FeatureSettings
from recon.stereo import filters, population
from recon.stereo.kernels.angle import angles
from recon.stereo.kernels.simd import Floats, Integers, kernel
from recon.stereo.kernels.threads import run
from recon.stereo.noise import estimate, floor_modulus

_CANDIDATE_SHARE = 0.5
"""Threshold for pixels to be matched or to support a match, relative to that of features."""

_HALF_TURN = np.float32(np.pi)
_EQUAL = np.float32(1 + 1e-5)


def detect(image: NDArray[np.uint8], settings: FeatureSettings) -> Features:
    """Find the oriented feature points of an image.

    Parameters
    ----------
    image : (H, W) or (H, W, 3) uint8, grey or RGB
    settings : FeatureSettings

    Returns
    -------
    Features

    Raises
    ------
    InputError
        If the image is not a uint8 image.
    """
    grey = to_grey(image)
    responses = filters.respond(grey, settings.widths_px)
    modulus, cosine, sine = responses[1:]
    noise = estimate(grey, responses.planes, settings.widths_px)
    lowest = max(settings.threshold, floor_modulus(noise, settings.widths_px))
    if settings.method == "population":
        lowest = settings.threshold
        middle = settings.widths_px[len(settings.widths_px) // 2]
        modulus, cosine, sine = population.encode(grey, filters.WAVELENGTH_OF_WIDTH * middle)
    ridge = _ridges(modulus, cosine, sine)
    strength = modulus.reshape(-1)[ridge]
    threshold = _threshold(strength, modulus.size, settings.share, lowest)
    rows = np.flatnonzero(strength >= threshold)
    place = ridge[rows]
    v, u = np.divmod(place, grey.shape[1])
    return Features(
        points_px=np.column_stack([u, v]).astype(np.float64),
        orientation_rad=_orientations(cosine.reshape(-1)[place], sine.reshape(-1)[place]),
        modulus=strength[rows],
        grey=grey,
        widths_px=settings.widths_px,
        planes=responses.planes,
        candidate_mask=modulus >= _CANDIDATE_SHARE * threshold,
        noise=noise,
    )


def detect_both(
    left: NDArray[np.uint8], right: NDArray[np.uint8], settings: FeatureSettings
) -> tuple[Features, Features]:
    """The feature points of two images, in parallel if threads are allowed."""
    first, second = run([partial(detect, image, settings) for image in (left, right)])
    return first, second


@njit(cache=True, error_model="numpy", nogil=True)
def _orientations(cosine: Floats, sine: Floats) -> Floats:
    """Angles in [0, pi) from vectors with doubled angle."""
    half = np.empty_like(cosine)
    angles(cosine, sine, half)
    for i in range(half.size):
        angle = half[i] / np.float32(2)
        angle = angle + _HALF_TURN if angle < 0 else angle
        half[i] = angle if angle < _HALF_TURN else np.float32(0)
    return half


def to_grey(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The brightness (H, W) of a grey or RGB image."""
    if image.dtype != np.uint8:
        raise InputError(f"image is {image.dtype}, but uint8 is needed")
    if not image.size or image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] != 3):
        raise InputError(f"image has shape {image.shape}, but (H, W) or (H, W, 3) is needed")
    if image.ndim == 2:
        return np.ascontiguousarray(image)
    grey: NDArray[np.uint8] = cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2GRAY)
    return grey


def _threshold(strength: Floats, num_pixels: int, share: float, lowest: float) -> float:
    """The minimum modulus of a feature: by value and by the desired number."""
    wanted = round(share * num_pixels)
    if wanted >= strength.size:
        return lowest
    if wanted == 0:
        return np.inf
    by_number = float(np.partition(strength, -wanted)[-wanted])
    return max(lowest, by_number)


@njit(cache=True, error_model="numpy", nogil=True)
def _ridges(modulus: Floats, cosine: Floats, sine: Floats) -> Integers:
    """Flat indices of the pixels whose modulus is maximal along the edge normal."""
    height, width = modulus.shape
    ridge, places, num = np.zeros(width, np.bool_), np.empty(height * width, np.int64), 0
    for v in range(1, height - 1):
        rows = modulus[v - 1], modulus[v], modulus[v + 1]
        _find_ridges(rows, cosine[v], sine[v], ridge)
        for u in range(width):
            places[num] = v * width + u
            num += ridge[u]
    return places[:num]


@kernel
def _find_ridges(
    rows: tuple[Floats, Floats, Floats], cosine: Floats, sine: Floats, ridge: NDArray[np.bool_]
) -> None:
    """Mark the pixels of a row whose neighbours along the normal are weaker.

    Each neighbour is interpolated between two pixels: on the nearer axis, and on the diagonal. The
    normal's doubled angle has cosine and sine proportional to those given. All neighbours are read
    before one is selected, so that the loop can be vectorised.
    """
    above, middle, below = rows
    for i in range(ridge.size - 2):
        c, s = cosine[i + 1], sine[i + 1]
        # Tangent of the angle to the nearer axis, from the doubled angle.
        share = abs(s) / (np.sqrt(c * c + s * s) + abs(c) + np.float32(1e-12))
        a, b, d = above[i], above[i + 1], above[i + 2]
        e, here, f = middle[i], middle[i + 1], middle[i + 2]
        g, h, j = below[i], below[i + 1], below[i + 2]
        ahead = f if c > 0 else (h if s > 0 else b)
        behind = e if c > 0 else (b if s > 0 else h)
        ahead += share * ((j if s > 0 else d) - ahead)
        behind += share * ((a if s > 0 else g) - behind)
        # Of two equal pixels exactly one is the ridge, regardless of rounding.
        ridge[i + 1] = (ahead * _EQUAL < here) & (behind <= here * _EQUAL)
