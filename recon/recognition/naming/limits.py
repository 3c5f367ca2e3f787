"""Limits of the catalogue, slightly blurred."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from recon.recognition.colour import mean_hue_deg
from recon.recognition.naming.kinds import Kind, PartRule, Sizes
from recon.recognition.segments.boxes import upright_box
from recon.records import Cone, Solid, Sphere, Voxels

Array = NDArray[np.float64]

RATIO_SPREAD = 0.05
"""Standard deviation of a size ratio, by which the limits of the catalogue are blurred."""
SIZE_SPREAD = 0.08
"""Standard deviation of the log of a size: stereo sizes are off by some percent."""
HUE_SPREAD_DEG = 15.0
"""Of a hue: lamps and shade turn it."""
LEAST_OF_HUE, NO_HUE = 0.1, 0.5
"""Chance of a part of another hue at least, and of one that is grey."""


def log_within(value: float, limits: tuple[float, float], spread: float) -> float:
    """Log probability that a value is within its limits, blurred by `spread`."""
    excess = max(limits[0] - value, value - limits[1]) / spread
    return -np.inf if excess > 2.0 else -float(np.logaddexp(0.0, 2.0 * excess))


def proportion_chance(kind: Kind, slenderness: float, elongation: float) -> float:
    """Chance (0 to 1) that an object has its kind's slenderness and elongation."""
    pairs = (slenderness, kind.slenderness), (elongation, kind.elongation)
    return float(np.exp(sum(_log_ratio_within(at, limits) for at, limits in pairs if limits)))


def size_chance(
    kind: Kind, rules: Sequence[PartRule], sizes: Sequence[Mapping[str, float]], cells: Voxels
) -> float:
    """Chance (0 to 1) that an object and its parts have its kind's sizes, all in metres.

    Parameters
    ----------
    rules : sequence of PartRule
        What each part that was found must be.
    sizes : sequence of mapping of str to float
        Height, width, depth and radius of each of them, as far as they are known.
    """
    chance = _log_chance(kind.size, box_sizes(cells.means))
    for rule, own in zip(rules, sizes, strict=True):
        chance += _log_chance(rule.size, own)
    # Well within its bounds a size costs nothing.
    return float(np.exp(chance))


def hue_chance(rules: Sequence[PartRule], parts: Sequence[Solid], cells: Voxels) -> float:
    """Chance (`LEAST_OF_HUE` to 1 for each part) that parts have the hues of their rules."""
    if all(rule.hue_deg is None for rule in rules):
        return 1.0
    nearest = np.argmin([solid.distances(cells.means) for solid in parts], axis=0)
    chances = [
        _of_hue(rule.hue_deg, mean_hue_deg(cells.shown_colours[nearest == number]))
        for number, rule in enumerate(rules)
        if rule.hue_deg is not None
    ]
    return float(np.prod(chances))


def _of_hue(bounds: tuple[float, float], hue_deg: float | None) -> float:
    """Chance of one part: light changes colours, so that no hue rules a kind out."""
    if hue_deg is None:
        return NO_HUE
    inside = (hue_deg - bounds[0]) % 360.0 <= (bounds[1] - bounds[0]) % 360.0
    away = min(abs((hue_deg - bound + 180.0) % 360.0 - 180.0) for bound in bounds)
    return max(float(np.exp(-0.5 * (0.0 if inside else away / HUE_SPREAD_DEG) ** 2)), LEAST_OF_HUE)


def _log_chance(bounds: Sizes, sizes: Mapping[str, float]) -> float:
    total = 0.0
    for name, (low, high) in bounds.given.items():
        if name in sizes:
            total += _log_ratio_within(sizes[name], (low, high))
    return total


def _log_ratio_within(value: float, limits: tuple[float, float]) -> float:
    """Log probability that a positive value is within its limits, blurred by some percent."""
    low, at, high = np.log(np.maximum([limits[0], value, limits[1]], 1e-9)).tolist()
    return log_within(at, (low, high), SIZE_SPREAD)


def box_sizes(points: Array) -> dict[str, float]:
    """Height, width, depth and radius of the upright box round points (N, 3)."""
    sizes = upright_box(points).sizes
    width, depth = max(sizes[0], sizes[2]), min(sizes[0], sizes[2])
    return {"height": float(sizes[1]), "width": width, "depth": depth, "radius": width / 2.0}


def solid_sizes(solid: Solid) -> dict[str, float]:
    """Those of its sizes that a round solid has."""
    if isinstance(solid, Sphere):
        size = 2.0 * solid.radius
        return {"height": size, "width": size, "depth": size, "radius": solid.radius}
    sizes: dict[str, float] = {}
    if isinstance(solid, Cone):
        sizes["radius"] = solid.height * float(np.tan(solid.half_angle_rad))
    for name in ("radius", "radius_bottom"):
        sizes["radius"] = getattr(solid, name, sizes.get("radius", 0.0))
    sizes["height"] = float(getattr(solid, "height", 0.0))
    return {name: size for name, size in sizes.items() if size > 0}
