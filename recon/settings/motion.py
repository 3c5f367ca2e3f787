"""Settings of the agent's body and of how it moves."""

from pydantic.dataclasses import dataclass

from recon.settings.stage import STRICT, Positive


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MotionSettings:
    """The body: an upright cylinder round the point midway between the cameras."""

    body_radius: Positive = 0.5
    """World units; nearer to a surface the body collides."""
    body_height: Positive = 5.5
    """World units, from the ground up."""
