"""A controller that goes once round the middle of the world, looking at it (thesis Appendix C)."""

import numpy as np

from recon.exploration.state import State
from recon.records import View


class Carousel:
    """Views on a circle round the middle, with a wider field of view than the settings."""

    radius = 8.0
    num_views = 12

    def next_view(self, state: State) -> View | None:
        """The next view on the circle; None after a whole turn."""
        if state.num_pairs > self.num_views:
            return None
        angle = 2.0 * np.pi * state.num_pairs / self.num_views
        height = state.settings.eyes.eye_height
        outwards = np.array([np.cos(angle), 0.0, np.sin(angle)])
        middle = np.array([0.0, height, 0.0])
        return View(position=middle + self.radius * outwards, target=middle, fov_deg=90.0)

    def info(self) -> str:
        """The plan, in a line."""
        return "once round the middle of the world"

    def result(self) -> str:
        """The result, in a line."""
        return f"{self.num_views} views on a circle"
