"""Slip: a simulated robot does not end up exactly where it intended to go."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from recon.exploration.floor import Array
from recon.exploration.referee import Referee
from recon.geometry import invert, pose, rotation_about_y, transform, without_drift
from recon.records import StereoPair, Trajectory, View
from recon.settings import Settings
from recon.settings.motion import MotionSettings


@dataclass(slots=True, kw_only=True, eq=False)
class Slip:
    """The transform between a robot's believed and true pose; errors add up.

    A step planned from the believed pose is executed from the true one, so an error of the heading
    also causes position errors.
    """

    motion: MotionSettings
    referee: Referee
    """Measures the true path."""
    T_true_believed: Array = field(default_factory=lambda: np.eye(4))
    """(4, 4) transform from the believed to the true world frame."""
    true_poses: list[Array] = field(default_factory=list)
    """(4, 4) true `T_world_left` of the pairs."""
    _rng: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng([self.motion.noise_seed, 0x51_1B])

    def walk(self, path: Array) -> Array | None:
        """Walk a believed path (N, 3); on a collision stay, return its believed position (2,)."""
        before = self.T_true_believed
        contact = self.referee.walk(self.err(path))
        if contact is None:
            return None
        self.T_true_believed = before
        x, z = contact
        return transform(invert(before), np.array([[x, 0.0, z]]))[0, [0, 2]]

    def err(self, path: Array) -> Array:
        """Add an error at the end of a believed path (N, 3); returns the true path (N + 1, 3)."""
        end = path[-1]
        led = transform(self.T_true_believed, path)
        x, z = self._rng.normal(0.0, self.motion.position_noise, size=2)
        turn = math.radians(self._rng.normal(0.0, self.motion.heading_noise_deg))
        about_end = pose(rotation_about_y(turn), end + np.array([x, 0.0, z])) @ pose(
            np.eye(3), -end
        )
        self.T_true_believed = without_drift(self.T_true_believed @ about_end)
        return np.vstack([led, transform(self.T_true_believed, end[None])])

    def true_view(self, view: View) -> View:
        """The true view for an intended one."""
        places = transform(self.T_true_believed, np.array([view.position, view.target]))
        return replace(view, position=places[0], target=places[1])

    def as_believed(self, pair: StereoPair) -> StereoPair:
        """A pair with the pose that the robot believes; the true one is recorded."""
        assert pair.T_world_left is not None
        self.true_poses.append(pair.T_world_left)
        T_believed_left = invert(self.T_true_believed) @ pair.T_world_left
        return replace(pair, T_world_left=without_drift(T_believed_left))

    def correct(self, T_new_old: Array) -> None:
        """Apply a correction of the believed pose; the true pose stays."""
        self.T_true_believed = without_drift(self.T_true_believed @ invert(T_new_old))

    def trajectory(self, believed: Trajectory) -> Trajectory:
        """The true poses, at the times of the believed ones."""
        poses = np.array(self.true_poses[: len(believed)]).reshape(-1, 4, 4)
        return Trajectory(stamps_s=believed.stamps_s, T_world_left=poses)

    def errors(self, believed: Trajectory) -> dict[str, float | None]:
        """The numbers of metrics.json for the error of the last believed pose."""
        if not len(believed):
            return {"pose_error_end": None, "pose_error_end_deg": None}
        T_true = self.true_poses[len(believed) - 1]
        off = invert(T_true) @ believed.T_world_left[-1]
        angle = float(Rotation.from_matrix(off[:3, :3]).magnitude())
        return {
            "pose_error_end": float(np.linalg.norm(off[:3, 3])),
            "pose_error_end_deg": math.degrees(angle),
        }


def slip_of(referee: Referee | None, settings: Settings) -> Slip | None:
    """The slip of a simulated robot; None if motion is exact or the truth is unknown."""
    if settings.motion.is_exact or referee is None:
        return None
    return Slip(motion=settings.motion, referee=referee)
