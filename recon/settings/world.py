"""Settings of the simulated world: its cameras and its renderer."""

import math
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import ArgsKwargs

from recon.settings.stage import NonNegative, Positive, table

_FOCAL_LENGTH = 0.1
_FOV_DEG = 80.0
SENSOR_WIDTH = 2.0 * _FOCAL_LENGTH * math.tan(math.radians(_FOV_DEG) / 2.0)
"""Width of the image on the sensor, world units: what the thesis's two values give together."""

PixelCount = Annotated[int, Field(ge=1, le=4096)]
"""More than 4096 x 4096 rays at a time do not fit into the memory of most machines."""

FOLLOWERS = {"focal_length": "fov_deg", "fov_deg": "focal_length"}
"""Settings that follow where another is changed, unless they are given too."""


@table
class EyesSettings:
    """The two simulated cameras (the thesis's table of parameters).

    Of focal length and field of view either follows from the other, by the width of the sensor.
    """

    width: PixelCount = 256
    """Of an image, pixels."""
    height: PixelCount = 256
    """Of an image, pixels."""
    baseline: Positive = 0.3
    """World units."""
    focal_length: Positive = _FOCAL_LENGTH
    """World units."""
    fov_deg: float = Field(default=_FOV_DEG, gt=0, lt=180)
    """Across the width."""
    near: Positive = 0.1
    """Nothing nearer is seen, world units."""
    far: Positive = 100.0
    """Nothing farther is seen, world units."""
    eye_height: Positive = 5.0
    """Height above the ground; a roof seen from below 5 gives next to no points."""
    gaze: Literal["shift", "toe-in"] = "shift"
    """Both cameras look at the target by shifted principal points, or by turning inwards."""
    auto_focus: bool = False
    """The explorer's cameras look twice: at the nearest thing the second time, and disparities are
    searched from infinity to somewhat nearer than it."""

    @model_validator(mode="before")
    @classmethod
    def _one_follows_from_the_other(cls, given: Any) -> Any:
        values = (given.kwargs or {}) if isinstance(given, ArgsKwargs) else given
        if not isinstance(values, dict):
            return given
        focal_length, fov_deg = values.get("focal_length"), values.get("fov_deg")
        if isinstance(focal_length, int | float) and fov_deg is None and focal_length > 0:
            half = math.atan(SENSOR_WIDTH / 2.0 / focal_length)
            return {**values, "fov_deg": math.degrees(2.0 * half)}
        if isinstance(fov_deg, int | float) and focal_length is None and 0 < fov_deg < 180:
            half = math.radians(fov_deg) / 2.0
            return {**values, "focal_length": SENSOR_WIDTH / 2.0 / math.tan(half)}
        return values

    @model_validator(mode="after")
    def _values_fit_together(self) -> Self:
        if not self.near < self.far:
            raise ValueError(f"near {self.near} is not nearer than far {self.far}")
        width = 2.0 * self.focal_length * math.tan(math.radians(self.fov_deg) / 2.0)
        if not math.isclose(width, SENSOR_WIDTH, rel_tol=1e-6):
            raise ValueError(
                f"focal_length {self.focal_length} and fov_deg {self.fov_deg} do not belong "
                "together; give one of them, the other follows"
            )
        return self


@table
class RenderSettings:
    """The renderer of images of the world, and the faults of its cameras."""

    renderer: str = "raycast"
    """raycast, filament, or the name of a plug-in."""
    texture_tile: Positive = 16.0
    """World units that a texture covers before it repeats."""
    supersampling: int = Field(default=2, ge=1, le=8)
    """Samples along each side of a pixel that shows an edge."""
    mipmaps: bool = True
    """Smooth textures by distance, so that far ones do not flicker."""
    shading: bool = False
    """The sun shines; else surfaces have their own colour, as features like it."""
    sky: bool = False
    """The sky deepens from the horizon up; else it has one colour."""
    fog: float = Field(default=0.0, ge=0, lt=1)
    """Share of the light that is lost in each world unit."""
    blur_px: NonNegative = 0.0
    """Standard deviation of the lens blur."""
    noise: NonNegative = 0.0
    """Standard deviation of the image noise, grey levels of 255."""
    noise_grain_px: NonNegative = 0.0
    """Standard deviation of the blur of the noise, which stays as strong in each pixel."""
    noise_seed: int = Field(default=0, ge=0)
    """Of the image noise; the seed of the run where not given."""
    gain_right: Positive = 1.0
    """Factor of the right image's grey levels."""
    offset_right: float = Field(default=0.0, ge=-255, le=255)
    """Grey levels added to the right image."""


@table
class WorldSettings:
    """The floor that is explored, round the origin."""

    size_x: Positive = 200.0
    """Of the floor along x, world units."""
    size_z: Positive = 200.0
    """Of the floor along z, world units."""
    height: Positive = 30.0
    """Above the ground; higher points are not obstacles, world units."""
