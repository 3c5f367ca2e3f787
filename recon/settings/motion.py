"""Settings of the agent's body and of its motion."""

from pydantic import Field

from recon.settings.stage import NonNegative, Positive, table


@table
class MotionSettings:
    """The body: an upright cylinder around the point midway between the cameras."""

    body_radius: Positive = 0.5
    """Radius of the body, world units; a surface nearer than this is a collision."""
    body_height: Positive = 5.5
    """Height of the body from the ground up, world units."""
    position_noise: NonNegative = 0.0
    """Standard deviation of the position error per step along x and along z, world units; the
    errors accumulate, and the agent corrects them from what it sees."""
    heading_noise_deg: float = Field(default=0.0, ge=0, le=180)
    """Standard deviation of the heading error per step."""
    noise_seed: int = Field(default=0, ge=0)
    """Seed of the motion errors; the run's own seed if not given."""

    @property
    def is_exact(self) -> bool:
        """True if the robot always arrives exactly at its goal."""
        return self.position_noise == self.heading_noise_deg == 0.0
