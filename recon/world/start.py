"""The first view of an agent."""

import numpy as np

from recon.records import View
from recon.settings.world import EyesSettings

START_DISTANCE = 2.0
"""Distance of the first target, in eye heights."""


def first_view(eyes: EyesSettings) -> View:
    """The middle of the floor, looking along -z."""
    height = eyes.eye_height
    return View(
        position=np.array([0.0, height, 0.0]),
        target=np.array([0.0, height, -START_DISTANCE * height]),
    )
