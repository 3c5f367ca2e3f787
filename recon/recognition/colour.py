"""Hue, saturation and value (Appendix D)."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GREY = 0.15
"""Below this saturation a hue is noise."""
DARK = 0.1
"""Below this value as well."""
VIVID_SHARE = 0.25
"""Share of the cells of a part that must have a hue for the part to have one."""
AGREEMENT = 0.5
"""Minimum length of the mean direction of hues that agree."""


def rgb_to_hsv(colours: NDArray[np.uint8]) -> Array:
    """Hue in degrees, saturation and value from 0 to 1, as defined in Appendix D.

    Parameters
    ----------
    colours : (N, 3) uint8

    Returns
    -------
    hsv : (N, 3) float64
        Hue in [0, 360), -1 where the colour is grey.
    """
    rgb = colours / 255.0
    value = rgb.max(axis=1)
    delta = value - rgb.min(axis=1)
    safe = np.where(delta > 0, delta, 1.0)
    r, g, b = rgb.T
    sector = np.select(
        [r == value, g == value], [(g - b) / safe, 2.0 + (b - r) / safe], 4.0 + (r - g) / safe
    )
    hue = np.where(delta > 0, np.mod(60.0 * sector, 360.0), -1.0)
    saturation = delta / np.where(value > 0, value, 1.0)
    return np.column_stack([hue, saturation, value])


def is_vivid(hsv: Array) -> NDArray[np.bool_]:
    """Mask (N,) of colours bright and saturated enough for a meaningful hue."""
    vivid: NDArray[np.bool_] = (hsv[:, 1] >= GREY) & (hsv[:, 2] >= DARK)
    return vivid


def mean_hue_deg(colours: NDArray[np.uint8]) -> float | None:
    """Circular mean hue of colours (N, 3); None if most are grey or the hues do not agree."""
    hsv = rgb_to_hsv(colours)
    vivid = is_vivid(hsv)
    if not vivid.any() or vivid.mean() < VIVID_SHARE:
        return None
    direction = np.exp(1j * np.radians(hsv[vivid, 0])).mean()
    if abs(direction) < AGREEMENT:
        return None
    return float(np.degrees(np.angle(direction)) % 360.0)
