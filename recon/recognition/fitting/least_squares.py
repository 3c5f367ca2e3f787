"""Robust non-linear least squares: maximum likelihood under Student-t noise.

Stereo noise has heavy tails, so residuals are assumed to be Student-t distributed; the scale is
estimated with the parameters (expectation maximisation), the steps are Levenberg-Marquardt steps.
"""

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.descent import NUM_RESCALINGS, descend
from recon.recognition.fitting.student import DEGREES_OF_FREEDOM, deviance, rescaled

Array = NDArray[np.float64]
State = TypeVar("State")

NO_PARTS: NDArray[np.int64] = np.empty((2, 0), dtype=np.int64)
"""Layout of a surface that is not a composite."""


class Model(Protocol[State]):
    """The surface that is fitted to points, and its state as numbers."""

    @property
    def points(self) -> Array:
        """(N, 3)"""
        ...

    @property
    def surface(self) -> int:
        """Number of the surface in `descent`."""
        ...

    def packed(self, state: State) -> Array:
        """The numbers of a state."""
        ...

    def unpacked(self, numbers: Array) -> State:
        """The state of numbers."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Estimate(Generic[State]):
    """The most likely state and its likelihood."""

    state: State
    residuals: Array
    """(N,) signed distances."""
    sigma: float
    """Scale of the Student-t noise."""
    information: Array
    """(P, P) inverse covariance of a step from the state."""
    deviance: float
    """Minus twice the log likelihood, up to a constant."""

    @property
    def bic(self) -> float:
        """Bayesian information criterion; the smallest is best."""
        return self.deviance + len(self.information) * float(np.log(len(self.residuals)))


def student_deviance(residuals: Array, floor: float) -> float:
    """Deviance of distances (N,) at their most likely scale, which is at least `floor`."""
    share = np.ones(len(residuals))
    start = max(floor, 1.4826 * float(np.median(np.abs(residuals))))
    sigma = rescaled(residuals, start, share, floor, DEGREES_OF_FREEDOM, NUM_RESCALINGS)
    return float(deviance(residuals, sigma, share, DEGREES_OF_FREEDOM))


def deviance_a_residual(residuals: Array, sigma: float) -> Array:
    """Deviance (N,) of each residual at a known scale."""
    tails: Array = np.log1p((residuals / sigma) ** 2 / DEGREES_OF_FREEDOM)
    return (DEGREES_OF_FREEDOM + 1.0) * tails + 2.0 * float(np.log(sigma))


def minimise(
    model: Model[State],
    start: State,
    *,
    floor: float,
    weights: Array | None = None,
    layout: NDArray[np.int64] = NO_PARTS,
    max_steps: int = 30,
) -> Estimate[State]:
    """Fit `model` from `start`.

    Parameters
    ----------
    floor : float
        Minimum noise, in the unit of the residuals; > 0.
    weights : (N,) float64, optional
        Relative weights of the residuals; equal by default.
    layout : (2, parts) int64, optional
        Of a composite.
    max_steps : int
        Maximum number of steps.
    """
    points = np.ascontiguousarray(model.points)
    share = np.ones(len(points)) if weights is None else weights / weights.mean()
    numbers, residuals, sigma, normal, lowest = descend(
        model.surface, points, model.packed(start), layout, share, floor, max_steps
    )
    return Estimate(
        state=model.unpacked(numbers),
        residuals=residuals,
        sigma=sigma,
        information=normal / sigma**2,
        deviance=lowest,
    )
