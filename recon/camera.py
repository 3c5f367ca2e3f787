"""A rectified pair of cameras: rays, projection, disparity <-> depth and its uncertainty."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError, check_number, check_shape

Array = NDArray[np.float64]

TYPICAL_RESIDUAL_PX = 0.13
"""Root mean square error of disparities due to the calibration of recorded cameras, unless stated:
that of published recorded pairs with truth."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StereoRig:
    """Intrinsics and baseline of a rectified stereo pair.

    Both cameras share the focal length, the row of the principal point and the orientation; the
    right one is at `baseline` on the left one's x axis. Pixel (0, 0) is the CENTRE of the top-left
    pixel, so the centre of an image of width W is at (W - 1) / 2.
    """

    width: int
    height: int
    focal_px: float
    cx_left_px: float
    cx_right_px: float
    cy_px: float
    baseline: float
    """Distance of the two cameras, in world units."""
    residual_px: float = TYPICAL_RESIDUAL_PX
    """Root mean square error of disparities due to the calibration. Neighbouring pixels share it:
    images do not reveal it. 0 if the calibration is exact, as in a simulator."""

    def __post_init__(self) -> None:
        for name in ("width", "height", "focal_px", "baseline"):
            check_number(f"rig {name}", getattr(self, name), above=0)
        for name in ("width", "height"):
            if getattr(self, name) % 1:
                raise InputError(
                    f"rig {name} is {getattr(self, name)}, but a whole number is needed"
                )
        for name in ("cx_left_px", "cx_right_px", "cy_px"):
            check_number(f"rig {name}", getattr(self, name))
        check_number("rig residual_px", self.residual_px, low=0)

    @property
    def disparity_offset_px(self) -> float:
        """Disparity of a point at infinity: `cx_left_px - cx_right_px`."""
        return self.cx_left_px - self.cx_right_px

    @property
    def K_left(self) -> Array:
        """(3, 3) matrix that projects from the left camera's frame to homogeneous pixels."""
        return np.array(
            [[self.focal_px, 0.0, self.cx_left_px], [0.0, self.focal_px, self.cy_px], [0, 0, 1.0]]
        )

    @property
    def T_left_right(self) -> Array:
        """(4, 4) transform from the right camera's frame to the left one's."""
        T = np.eye(4)
        T[0, 3] = self.baseline
        return T

    def depth(self, disparity_px: ArrayLike) -> Array:
        """Depths along the left z axis; NaN where the rays do not meet in front of the cameras."""
        shift = np.asarray(disparity_px, dtype=np.float64) - self.disparity_offset_px
        with np.errstate(divide="ignore", invalid="ignore"):
            z: Array = np.where(shift > 0, self.focal_px * self.baseline / shift, np.nan)
        return z

    def disparity(self, depth: ArrayLike) -> Array:
        """Disparity `u_left - u_right` in pixels of points at `depth` > 0."""
        z = np.asarray(depth, dtype=np.float64)
        d: Array = self.focal_px * self.baseline / z + self.disparity_offset_px
        return d

    def depth_sigma(self, depth: ArrayLike, sigma_px: ArrayLike) -> Array:
        """Standard deviation of depths: ``sigma_z = z^2 / (f b) sigma_d``, world units."""
        z = np.asarray(depth, dtype=np.float64)
        sigma: Array = z * z / (self.focal_px * self.baseline) * np.asarray(sigma_px)
        return sigma

    def rays(self, points_px: ArrayLike) -> Array:
        """Directions (N, 3), with z = 1, of left image points (N, 2), in the left frame."""
        uv = np.asarray(points_px, dtype=np.float64)
        check_shape("points_px", uv, (None, 2))
        x = (uv[:, 0] - self.cx_left_px) / self.focal_px
        y = (uv[:, 1] - self.cy_px) / self.focal_px
        return np.column_stack([x, y, np.ones(len(uv))])

    def triangulate(self, points_px: ArrayLike, disparity_px: ArrayLike) -> Array:
        """Points in the left camera's frame, from their disparities (Eq 19).

        Parameters
        ----------
        points_px : (N, 2) array_like
            Points of the left image.
        disparity_px : (N,) array_like

        Returns
        -------
        points_left : (N, 3) float64
            NaN where the rays do not meet in front of the cameras.
        """
        points: Array = self.rays(points_px) * self.depth(disparity_px)[:, None]
        return points

    def project_left(self, points_left: ArrayLike) -> Array:
        """Left image points (N, 2) of points (N, 3) in the left frame."""
        return self._project(np.asarray(points_left, dtype=np.float64), self.cx_left_px)

    def project_right(self, points_left: ArrayLike) -> Array:
        """Right image points (N, 2) of points (N, 3) in the LEFT frame."""
        points_right = np.asarray(points_left, dtype=np.float64) - np.array([self.baseline, 0, 0])
        return self._project(points_right, self.cx_right_px)

    def _project(self, points: Array, cx_px: float) -> Array:
        check_shape("points_left", points, (None, 3))
        xy = self.focal_px * points[:, :2] / points[:, 2:]
        projected: Array = xy + np.array([cx_px, self.cy_px])
        return projected
