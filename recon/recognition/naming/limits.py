"""Limits of the catalogue, slightly blurred."""

from collections.abc import Sequence

import numpy as np

from recon.recognition.naming.kinds import Kind, Sizes
from recon.recognition.segments.boxes import upright_box
from recon.records import Cone, Solid, Sphere, Voxels

RATIO_SPREAD = 0.05
"""Standard deviation of a size ratio, by which the limits of the catalogue are blurred."""
SIZE_SPREAD = 0.08
"""Standard deviation of the log of a size in metres: stereo sizes are off by some percent."""


def log_within(value: float, limits: tuple[float, float], spread: float) -> float:
    """Log probability that a value is within its limits, blurred by `spread`."""
    excess = max(limits[0] - value, value - limits[1]) / spread
    return -np.inf if excess > 2.0 else -float(np.logaddexp(0.0, 2.0 * excess))


def size_chance(kind: Kind, parts: Sequence[Solid], cells: Voxels) -> float:
    """Probability (0 to 1) that an object has its kind's sizes, all in metres."""
    chance = _log_chance(kind.size, _box_sizes(cells))
    if len(parts) == len(kind.parts):
        pairs = zip(kind.parts, parts, strict=True)
        chance += sum(_log_chance(rule.size, _solid_sizes(solid)) for rule, solid in pairs)
    # A size well within its limits costs nothing.
    return float(np.exp(chance))


def _log_chance(bounds: Sizes, sizes: dict[str, float]) -> float:
    total = 0.0
    for name, (low, high) in bounds.given.items():
        if name in sizes:
            limits = float(np.log(max(low, 1e-9))), float(np.log(max(high, 1e-9)))
            total += log_within(float(np.log(max(sizes[name], 1e-9))), limits, SIZE_SPREAD)
    return total


def _box_sizes(cells: Voxels) -> dict[str, float]:
    sizes = upright_box(cells.means).sizes
    width, depth = max(sizes[0], sizes[2]), min(sizes[0], sizes[2])
    return {"height": float(sizes[1]), "width": width, "depth": depth, "radius": width / 2.0}


def _solid_sizes(solid: Solid) -> dict[str, float]:
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
