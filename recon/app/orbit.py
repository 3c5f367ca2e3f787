"""The camera of a 3D view: it orbits a point, zooms, and pans."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.geometry import look_at
from recon.world.raster import Lens

Array = NDArray[np.float64]

FOV_DEG = 45.0
MAX_ELEVATION = np.radians(89.9)
TURN_PER_PIXEL = 0.008
ABOVE = 0.3
"""Elevation of a view from behind a camera, radians."""
ZOOM = 1.15
NEAREST, FARTHEST = 1e-4, 1e7
DEFAULT = "default"
VIEWS = {
    DEFAULT: (0.5, 0.5), "front": (0.0, 0.0), "back": (np.pi, 0.0), "side": (np.pi / 2.0, 0.0),
    "top": (0.0, float(MAX_ELEVATION)),
}  # fmt: skip
"""Azimuth, from +z towards +x, and elevation of the camera, radians."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Orbit:
    """A camera position on a sphere around a point."""

    target: Array
    """(3,) world."""
    distance: float
    azimuth: float = 0.5
    elevation: float = 0.5

    @classmethod
    def round(cls, low: Array, high: Array) -> "Orbit":
        """An orbit far enough away to see a whole box."""
        reach = float(np.linalg.norm(high - low)) / 2.0 or 1.0
        return cls(
            target=(low + high) / 2.0, distance=reach / np.sin(np.radians(FOV_DEG) / 2.0) * 0.85
        )

    def behind(self, T_world_cam: Array) -> "Orbit":
        """Turned to the direction of a camera, from slightly above."""
        away = -T_world_cam[:3, 2]
        azimuth = float(np.arctan2(away[0], away[2]))
        return replace(self, azimuth=azimuth, elevation=ABOVE)

    @property
    def position(self) -> Array:
        """(3,) position of the camera."""
        flat = np.cos(self.elevation)
        away = (
            flat * np.sin(self.azimuth), np.sin(self.elevation), flat * np.cos(self.azimuth)
        )  # fmt: skip
        return self.target + self.distance * np.array(away)

    def lens(self, width: int, height: int) -> Lens:
        """The camera for an image of that size."""
        return Lens(
            T_world_cam=look_at(self.position, self.target), width=width, height=height,
            focal_px=height / 2.0 / float(np.tan(np.radians(FOV_DEG) / 2.0)),
            near=1e-3 * self.distance,
        )  # fmt: skip

    def turned(self, right_px: float, down_px: float) -> "Orbit":
        """The orbit rotated by a drag of the mouse."""
        elevation = self.elevation + TURN_PER_PIXEL * down_px
        return replace(
            self,
            azimuth=self.azimuth - TURN_PER_PIXEL * right_px,
            elevation=float(np.clip(elevation, -MAX_ELEVATION, MAX_ELEVATION)),
        )

    def moved(self, right_px: float, down_px: float, height_px: int) -> "Orbit":
        """The orbit shifted so that the target follows the mouse."""
        T = look_at(self.position, self.target)
        unit = 2.0 * self.distance * np.tan(np.radians(FOV_DEG) / 2.0) / height_px
        return replace(self, target=self.target - unit * (right_px * T[:3, 0] + down_px * T[:3, 1]))

    def zoomed(self, steps: float) -> "Orbit":
        """The orbit zoomed, nearer for positive steps."""
        distance = float(np.clip(self.distance * ZOOM**-steps, NEAREST, FARTHEST))
        return replace(self, distance=distance)

    def facing(self, other: "Orbit") -> "Orbit":
        """Turned to the direction of another one."""
        return replace(self, azimuth=other.azimuth, elevation=other.elevation)

    def seen_from(self, view: str) -> "Orbit":
        """The orbit from one of VIEWS."""
        azimuth, elevation = VIEWS[view]
        return replace(self, azimuth=azimuth, elevation=elevation)
