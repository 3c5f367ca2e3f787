"""Feature points: where the response of the steerable filters has a ridge (thesis 3.3)."""

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import Features
from recon.settings import FeatureSettings
from recon.stereo import filters

_CANDIDATE_SHARE = 0.5
"""A pixel may be matched, or support a match, from this share of the features' threshold on."""


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
        Where the image is no uint8 picture.
    """
    grey = to_grey(image)
    responses = np.empty(
        (len(settings.widths_px), filters.DESCRIPTORS, 2, *grey.shape), dtype=np.float32
    )
    harmonics = np.zeros((3, *grey.shape), dtype=np.float32)
    for width_px, planes in zip(settings.widths_px, responses, strict=True):
        filters.respond(grey.astype(np.float32), width_px, planes, harmonics)
    modulus, ridge = _ridges(harmonics)
    threshold = _threshold(modulus, ridge, settings)
    v, u = np.nonzero(ridge & (modulus >= threshold))
    return Features(
        points_px=np.column_stack([u, v]).astype(np.float64),
        orientation_rad=np.mod(np.arctan2(harmonics[2], harmonics[1])[v, u] / 2, np.pi),
        modulus=modulus[v, u],
        grey=grey,
        widths_px=settings.widths_px,
        planes=responses,
        candidate_mask=modulus >= _CANDIDATE_SHARE * threshold,
    )


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


def _threshold(
    modulus: NDArray[np.float32], ridge: NDArray[np.bool_], settings: FeatureSettings
) -> float:
    """The modulus from which on a ridge pixel is a feature: by value and by number wanted."""
    on_ridge = modulus[ridge]
    wanted = round(settings.share * modulus.size)
    if wanted >= on_ridge.size:
        return settings.threshold
    if wanted == 0:
        return np.inf
    by_number = float(np.partition(on_ridge, -wanted)[-wanted])
    return max(settings.threshold, by_number)


@njit(cache=True, error_model="numpy")
def _ridges(harmonics: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Modulus, and where it is the largest along the normal of the edge."""
    _, height, width = harmonics.shape
    modulus = np.empty((height, width), np.float32)
    for y in range(height):
        for x in range(width):
            c, s = harmonics[1, y, x], harmonics[2, y, x]
            modulus[y, x] = np.sqrt(max(harmonics[0, y, x] + np.sqrt(c * c + s * s), 0.0))
    ridge = np.zeros((height, width), np.bool_)
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            angle = 0.5 * np.arctan2(harmonics[2, y, x], harmonics[1, y, x])
            ridge[y, x] = _is_ridge(modulus, y, x, np.cos(angle), np.sin(angle))
    return modulus, ridge


@njit(cache=True, error_model="numpy")
def _is_ridge(modulus: NDArray[np.float32], y: int, x: int, nx: float, ny: float) -> bool:
    """Whether the neighbours along the normal are weaker; they are mixed of two pixels each."""
    if abs(nx) > abs(ny):
        dy, dx, corner_dy, corner_dx = 0, _sign(nx), _sign(ny), _sign(nx)
        share = abs(ny / nx)
    else:
        dy, dx, corner_dy, corner_dx = _sign(ny), 0, _sign(ny), _sign(nx)
        share = abs(nx / ny)
    ahead = (1 - share) * modulus[y + dy, x + dx] + share * modulus[y + corner_dy, x + corner_dx]
    behind = (1 - share) * modulus[y - dy, x - dx] + share * modulus[y - corner_dy, x - corner_dx]
    return bool(ahead < modulus[y, x] >= behind)


@njit(cache=True)
def _sign(number: float) -> int:
    return 1 if number > 0 else -1
