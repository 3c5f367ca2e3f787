"""How sure a disparity is, from what was seen when it was chosen.

The laws were fitted on recorded pairs with truth (Venus, Cones, Moebius, Cloth1, Books), so that
68 % of the errors there are below one sigma, and judged on others.
"""

import numpy as np

from recon.stereo.dense.choice import Choice
from recon.stereo.kernels.simd import Floats

FILLED_PX = np.float32(1.0)
"""Of what was filled in: four of five are within a pixel."""
_LOWEST_PX, _HIGHEST_PX = 0.03, 8.0


def of_choice(choice: Choice, spread_px: Floats) -> Floats:
    """(H, W) standard deviation of disparities that were chosen by their cost.

    It falls with the steepness of the cost and its lead over other disparities, both in grey
    levels, and grows with the distance of the neighbours from a common plane.
    """
    lead = (0.3 + choice.steepness) ** -0.29 * (0.5 + choice.lead) ** -0.5
    return _bounded(16.9 * lead * (0.03 + spread_px) ** 0.45)


def of_spread(spread_px: Floats) -> Floats:
    """(H, W) the same, where only the neighbours' distance from a common plane is known."""
    return _bounded(1.45 * (0.03 + spread_px) ** 0.7)


def _bounded(sigma_px: Floats) -> Floats:
    return np.clip(sigma_px, _LOWEST_PX, _HIGHEST_PX).astype(np.float32)
