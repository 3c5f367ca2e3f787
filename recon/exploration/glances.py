"""Glances: an agent uncertain of its position turns to known landmarks."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from recon.exploration.floor import Array
from recon.exploration.landmarks import DISTANCE_SHARE, Expected, Sighter
from recon.exploration.outlines import GAP_RAD
from recon.records import View

NUM_HEADINGS = 24
SURE_CELLS = 0.15
"""Sufficient standard deviation of a position, in cells, including that due to the heading."""
GAIN = 0.95
"""A glance is worth a pair if it leaves less than this share of the standard deviation."""
NUM_SIGMAS = 2.0
"""Standard deviations of its direction within which a landmark is to be in view."""
MARGIN_RAD = 2.0 * GAP_RAD
"""Minimum angle between an edge to be seen and the image border."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """The field of view of the cameras."""

    half_rad: float
    """Half its width, radians."""
    reach: float
    """Distance up to which objects are seen, world units."""

    def takes_in(self, landmark: int, expected: Expected, joint: Array) -> bool:
        """True if both edges of a landmark are surely in view, and nothing nearer hides them."""
        azimuth, half = expected.azimuth_rad, expected.half_rad
        unsure = NUM_SIGMAS * math.sqrt(expected.spread(landmark, joint)[0, 0])
        if abs(azimuth[landmark]) + half[landmark] + unsure > self.half_rad - MARGIN_RAD:
            return False
        nearer = expected.range < expected.range[landmark]
        gap = np.abs(azimuth - azimuth[landmark]) - half - half[landmark]
        return bool(expected.front[landmark] < self.reach and not (nearer & (gap < GAP_RAD)).any())


def glance(
    sighter: Sighter,
    step_sigma: tuple[float, float],
    field: Field,
    sure: float,
    arm: float,
    tried: Sequence[float] = (),
) -> float | None:
    """The most informative heading (radians) for a pose; None if it is certain, or none helps.

    Parameters
    ----------
    sighter : Sighter
        At the last pose.
    step_sigma : (float, float)
        Errors of turning on the spot: of position, world units, and heading, radians.
    field : Field
    sure : float
        Sufficient standard deviation of the position, world units.
    arm : float
        Distance at which an error of the heading is weighed, world units.
    tried : sequence of float
        Headings of glances from here, which are not repeated.
    """
    now = _cost(sighter.joint, arm)
    if now < sure or not len(sighter.graph.radii):
        return None
    headings = np.linspace(0.0, 2.0 * np.pi, NUM_HEADINGS, endpoint=False).tolist()
    left = [one for one in headings if one not in tried]
    costs = [_cost(_after(sighter, one, step_sigma, field), arm) for one in left]
    if not costs or min(costs) >= GAIN * now:
        return None
    return float(left[int(np.argmin(costs))])


def _cost(joint: Array, arm: float) -> float:
    """Standard deviation of the position, including that due to the heading at a distance."""
    return math.sqrt(float(joint[0, 0] + joint[1, 1] + arm**2 * joint[2, 2]))


def _after(
    sighter: Sighter, heading: float, step_sigma: tuple[float, float], field: Field
) -> Array:
    """(3, 3) covariance of the pose after a view in some direction (Kalman update)."""
    x, z, _ = sighter.graph.poses[-1]
    expected = Expected.of(sighter.graph, np.array([x, z, heading]))
    spread = sighter.joint.copy()
    spread[[0, 1, 2], [0, 1, 2]] += np.array([step_sigma[0], step_sigma[0], step_sigma[1]]) ** 2
    seen = [m for m in range(len(expected.range)) if field.takes_in(m, expected, spread)]
    rows = np.zeros((2 * len(seen), len(spread)))
    noise, growth = np.zeros(2 * len(seen)), sighter.growth
    for at, landmark in enumerate(seen):
        rows[2 * at : 2 * at + 2, :3] = expected.derivative[landmark, :, :3]
        own = slice(3 + 3 * landmark, 6 + 3 * landmark)
        rows[2 * at : 2 * at + 2, own] = expected.derivative[landmark, :, 3:]
        radius = sighter.graph.radii[landmark]
        noise[2 * at] = math.hypot(
            sighter.edge_sigma, sighter.graph.shapes[landmark] * radius / expected.range[landmark]
        )
        noise[2 * at + 1] = math.hypot(
            DISTANCE_SHARE * radius, growth * expected.range[landmark] ** 2
        )
    innovation = rows @ spread @ rows.T + np.diag(noise**2)
    gain = np.linalg.solve(innovation, rows @ spread)
    after: Array = (spread - spread @ rows.T @ gain)[:3, :3]
    return after


def turned(view: View, heading: float, gaze: float) -> View:
    """A view from the same position in another direction."""
    ahead = np.array([math.cos(heading), 0.0, math.sin(heading)])
    return View(position=view.position, target=view.position + gaze * ahead)
