"""The pose of a pair in a known map, and its uncertainty."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.errors import check_shape
from recon.geometry import check_rigid

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PoseEstimate:
    """A pose of the left camera, measured against a map."""

    T_world_left: Array
    """(4, 4) pose of the left camera."""
    covariance: Array
    """(6, 6) of a small rotation about the world's x, y, z (radians) and of the camera's position
    (world units)."""
    probability: float
    """Probability that this is the true place, not another one that looks alike."""
    residual: float
    """Root mean square distance from the surface of the map, standard deviations."""
    inlier_share: float
    """Share of the pair's points that lie on the map."""
    num_cells: int
    """Number of map cells used."""

    def __post_init__(self) -> None:
        check_rigid("T_world_left", self.T_world_left)
        check_shape("covariance", self.covariance, (6, 6))

    def __repr__(self) -> str:
        x, y, z = self.T_world_left[:3, 3]
        return (
            f"PoseEstimate({x:.3g}, {y:.3g}, {z:.3g} +- {self.sigma:.2g}, "
            f"{self.sigma_deg:.2g} deg, probability {self.probability:.2f})"
        )

    @property
    def sigma(self) -> float:
        """Standard deviation of the position, along its most uncertain direction, world units."""
        return _largest(self.covariance[3:, 3:])

    @property
    def sigma_deg(self) -> float:
        """Standard deviation of the orientation, about its most uncertain axis."""
        return float(np.degrees(_largest(self.covariance[:3, :3])))


def _largest(covariance: Array) -> float:
    return float(np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0)))
