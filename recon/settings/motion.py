"""Settings of the agent's body and of how it moves."""

from pydantic import Field

from recon.settings.stage import NonNegative, Positive, table


@table
class MotionSettings:
    """The body: an upright cylinder round the point midway between the cameras."""

    body_radius: Positive = 0.5
    """World units; nearer to a surface the body collides."""
    body_height: Positive = 5.5
    """World units, from the ground up."""
    position_noise: NonNegative = 0.0
    """Standard deviation of the error of each step along x and along z, world units; the errors
    add up, and the agent corrects them by what it sees."""
    heading_noise_deg: NonNegative = 0.0
    """Standard deviation of the error of the heading after each step."""
    noise_seed: int = Field(default=0, ge=0)
    """Of the errors of motion; the seed of the run where not given."""

    @property
    def is_exact(self) -> bool:
        """True where the robot always comes to stand where it meant to go."""
        return self.position_noise == self.heading_noise_deg == 0.0
