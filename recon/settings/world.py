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
"""More than 4096 x 4096 rays at once do not fit into the memory of most machines."""
Blur = Annotated[float, Field(ge=0, le=100)]
"""Standard deviation in pixels; kernels of larger ones take more memory than images."""

FOLLOWERS = {"focal_length": "fov_deg", "fov_deg": "focal_length"}
"""Settings that follow when another one is changed, unless they are given as well."""


@table
class EyesSettings:
    """The two simulated cameras (the thesis's table of parameters).

    Focal length and field of view each follow from the other, through the sensor width.
    """

    width: PixelCount = 256
    """Image width, pixels."""
    height: PixelCount = 256
    """Image height, pixels."""
    baseline: Positive = 0.3
    """Distance between the two cameras, world units."""
    focal_length: Positive = _FOCAL_LENGTH
    """Focal length, world units; the field of view follows from it."""
    fov_deg: float = Field(default=_FOV_DEG, gt=0, lt=180)
    """Horizontal field of view; the focal length follows from it."""
    near: Positive = 0.1
    """Near clipping distance, world units."""
    far: Positive = 100.0
    """Far clipping distance, world units."""
    eye_height: Positive = 5.0
    """Height of the cameras above the ground, world units; from below 5, the village's roofs give
    hardly any points."""
    gaze: Literal["shift", "toe-in"] = "shift"
    """Both cameras look at the target by shifted principal points, or by turning inwards."""
    auto_focus: bool = False
    """Take each view twice: the second time the cameras look at the nearest thing seen, and
    disparities are searched from infinity to a little nearer than it."""

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
    """Length after which a texture repeats, world units."""
    supersampling: int = Field(default=2, ge=1, le=8)
    """Samples per pixel along each axis, for pixels that show an edge."""
    mipmaps: bool = True
    """Filter textures by distance, so that distant ones do not flicker."""
    shading: bool = False
    """Light the scene by a sun; otherwise surfaces show their plain colour."""
    sky: bool = False
    """Let the sky darken from the horizon upwards; otherwise it has a single colour."""
    fog: float = Field(default=0.0, ge=0, lt=1)
    """Share of the light lost per world unit of distance."""
    blur_px: Blur = 0.0
    """Standard deviation of the lens blur, pixels."""
    noise: NonNegative = 0.0
    """Standard deviation of the image noise, grey levels (of 255)."""
    noise_grain_px: Blur = 0.0
    """Grain of the image noise: it is blurred with this standard deviation (pixels), its strength
    per pixel unchanged."""
    noise_seed: int = Field(default=0, ge=0)
    """Seed of the image noise; the run's own seed if not given."""
    gain_right: Positive = 1.0
    """Factor applied to the grey levels of the right image."""
    offset_right: float = Field(default=0.0, ge=-255, le=255)
    """Grey levels added to the right image."""


@table
class WorldSettings:
    """The floor to explore, centred on the origin."""

    size_x: Positive = 200.0
    """Size of the floor along x, world units."""
    size_z: Positive = 200.0
    """Size of the floor along z, world units."""
    height: Positive = 30.0
    """Height above the ground up to which points are obstacles, world units."""
