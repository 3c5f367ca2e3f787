"""Feature strength and orientation by population coding with Gabor filters (thesis 3.2)."""

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.stereo.kernels.simd import Floats

_NUM_FILTERS = 8
_SIGMA_OF_WAVELENGTH = 0.4
"""Width of the envelope: the filter passes slightly more than an octave."""
_TRUNCATION = 3.0
"""Half size of the kernels, in standard deviations."""


def encode(grey: NDArray[np.uint8], wavelength_px: float) -> tuple[Floats, Floats, Floats]:
    """Encode the edges of an image by a population vector.

    Parameters
    ----------
    grey : (H, W) uint8
    wavelength_px : float

    Returns
    -------
    strength : (H, W) float32
        Length of the population vector times its certainty, in grey levels.
    cosine, sine : (H, W) float32
        The vector (Eq 9). Its angle is TWICE that of the edge normal: with single angles, as in Eq
        10, opposite directions would not be the same edge.
    """
    angles = np.arange(_NUM_FILTERS) * np.pi / _NUM_FILTERS
    image = grey.astype(np.float32)
    moduli = np.array([_modulus(image, wavelength_px, angle) for angle in angles])
    cosine = np.tensordot(np.cos(2 * angles), moduli, 1)
    sine = np.tensordot(np.sin(2 * angles), moduli, 1)
    length = np.hypot(cosine, sine)
    # One minus the angular variance: 1 where the whole response is in one direction.
    certainty = length / np.maximum(moduli.sum(axis=0), 1e-6)
    strength = (length * certainty).astype(np.float32)
    return strength, cosine.astype(np.float32), sine.astype(np.float32)


def _modulus(grey: Floats, wavelength_px: float, angle: float) -> Floats:
    """Modulus of the response of one complex Gabor filter (Eq 8)."""
    kernel = gabor(wavelength_px, angle)
    border = cv2.BORDER_REPLICATE
    real = cv2.filter2D(grey, cv2.CV_32F, kernel.real, borderType=border)
    imag = cv2.filter2D(grey, cv2.CV_32F, kernel.imag, borderType=border)
    modulus: Floats = cv2.magnitude(real, imag)
    return modulus


def gabor(wavelength_px: float, angle: float) -> NDArray[np.complex128]:
    """Complex Gabor kernel with zero mean, whose weights' moduli sum to 1."""
    sigma = _SIGMA_OF_WAVELENGTH * wavelength_px
    radius = int(np.ceil(_TRUNCATION * sigma))
    v, u = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    envelope = np.exp(-(u**2 + v**2) / (2 * sigma**2))
    envelope /= envelope.sum()
    wave = np.exp(2j * np.pi / wavelength_px * (u * np.cos(angle) + v * np.sin(angle)))
    kernel: NDArray[np.complex128] = envelope * (wave - (envelope * wave).sum())
    return kernel
