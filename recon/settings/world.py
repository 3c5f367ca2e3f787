"""Settings of the simulated world: its eyes and its renderer."""

import math
from typing import Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from recon.settings.stage import STRICT, Count, Positive


@dataclass(frozen=True, kw_only=True, config=STRICT)
class EyesSettings:
    """The two simulated cameras (the thesis's table of parameters)."""

    width: Count = 256
    height: Count = 256
    baseline: Positive = 0.3
    """World units."""
    focal_length: Positive = 0.1
    """World units; tied to the field of view by the width of the sensor."""
    fov_deg: float = Field(default=80.0, gt=0, lt=180)
    near: Positive = 0.1
    far: Positive = 100.0
    eye_height: Positive = 5.0
    """Height above the ground; a roof seen from below 5 gives next to no points."""
    gaze: Literal["shift", "toe-in"] = "shift"
    """How both eyes look at the target: by shifted principal points, or by turning inwards."""

    @model_validator(mode="after")
    def _near_before_far(self) -> Self:
        if not self.near < self.far:
            raise ValueError(f"near {self.near} is not nearer than far {self.far}")
        return self

    @property
    def sensor_width(self) -> float:
        """Width of the picture on the sensor, world units."""
        return 2.0 * self.focal_length * math.tan(math.radians(self.fov_deg) / 2.0)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class RenderSettings:
    """How pictures of the world are made."""

    renderer: Literal["raycast", "filament"] = "raycast"
    supersampling: int = Field(default=2, ge=1, le=8)
    """Samples along each side of a pixel."""
    mipmaps: bool = True


@dataclass(frozen=True, kw_only=True, config=STRICT)
class WorldSettings:
    """The floor that is explored, round the origin."""

    size_x: Positive = 200.0
    size_z: Positive = 200.0
    height: Positive = 30.0
