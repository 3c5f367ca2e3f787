"""Feature points of one image, and the pairs that two images make of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Features:
    """Oriented feature points with their complex filter responses."""

    points_px: NDArray[np.float64]
    """(N, 2) u, v."""
    orientation_rad: NDArray[np.float64]
    """(N,) direction across the edge (of its normal), in [0, pi)."""
    response: NDArray[np.complex64]
    """(N, S) response at the point's own orientation, one column a scale."""

    def __len__(self) -> int:
        return len(self.points_px)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Matches:
    """Pairs of one left and one right feature, most confident first; no left point twice."""

    points_px: NDArray[np.float64]
    """(M, 2) u, v in the left image."""
    disparity_px: NDArray[np.float64]
    """(M,) u_left - u_right."""
    sigma_px: NDArray[np.float64]
    """(M,) standard deviation of the disparity."""
    score: NDArray[np.float64]
    """(M,) confidence, falling."""
    index_left: NDArray[np.int32]
    """(M,) row of the left feature."""
    index_right: NDArray[np.int32]
    """(M,) row of the right feature."""

    def __len__(self) -> int:
        return len(self.points_px)

    def select(self, rows: NDArray[np.integer] | NDArray[np.bool_] | slice) -> "Matches":
        """The matches of `rows`, in that order."""
        return Matches(**{name: getattr(self, name)[rows] for name in Matches.__slots__})
