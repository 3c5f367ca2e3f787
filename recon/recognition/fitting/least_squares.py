"""Robust non-linear least squares: maximum likelihood under Student-t noise.

Stereo noise has heavy tails, so residuals are assumed to be Student-t distributed; the scale is
estimated with the parameters (expectation maximisation), the steps are Levenberg-Marquardt steps.
"""

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.student import (
    damped_step,
    deviance,
    normal_equations,
    rescaled,
)

Array = NDArray[np.float64]
State = TypeVar("State")

DEGREES_OF_FREEDOM = 3.0
"""Degrees of freedom of the Student-t noise: low enough that 10 % gross outliers do not affect a
fit."""
CONVERGED = 1e-2
"""The fit has converged when a step lowers -2 log likelihood by less than this."""
NUM_RESCALINGS = 3
MAX_DAMPING = 1e3


class Model(Protocol[State]):
    """A model to fit: the residuals of points, and the update of parameters by a step."""

    def residuals(self, state: State) -> tuple[Array, Array]:
        """Signed distances (N,) and their derivatives (N, P) with respect to a step."""
        ...

    def transformed(self, state: State, step: Array) -> State:
        """The state after a step (P,)."""
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

    @property
    def covariance(self) -> Array:
        """Covariance (P, P) of a step from the state."""
        return np.linalg.pinv(self.information, hermitian=True).astype(np.float64)


def student_deviance(residuals: Array, floor: float) -> float:
    """Deviance of distances (N,) at their most likely scale, which is at least `floor`."""
    share = np.ones(len(residuals))
    start = max(floor, 1.4826 * float(np.median(np.abs(residuals))))
    return _deviance(residuals, _rescaled(residuals, start, share, floor), share)


def deviance_a_residual(residuals: Array, sigma: float) -> Array:
    """Deviance (N,) of each residual at a known scale."""
    tails: Array = np.log1p((residuals / sigma) ** 2 / DEGREES_OF_FREEDOM)
    return (DEGREES_OF_FREEDOM + 1.0) * tails + 2.0 * float(np.log(sigma))


def _deviance(residuals: Array, sigma: float, share: Array) -> float:
    return float(deviance(residuals, sigma, share, DEGREES_OF_FREEDOM))


def _rescaled(residuals: Array, sigma: float, share: Array, floor: float) -> float:
    """The scale after a few rounds of expectation maximisation."""
    return float(rescaled(residuals, sigma, share, floor, DEGREES_OF_FREEDOM, NUM_RESCALINGS))


def minimise(
    model: Model[State],
    start: State,
    *,
    floor: float,
    weights: Array | None = None,
    max_steps: int = 30,
) -> Estimate[State]:
    """Fit `model` from `start`.

    Parameters
    ----------
    floor : float
        Minimum noise, in the unit of the residuals; > 0.
    weights : (N,) float64, optional
        Relative weights of the residuals; equal by default.
    max_steps : int
        Maximum number of steps.
    """
    state, damping = start, 1e-3
    residuals, jacobian = model.residuals(state)
    share = np.ones(len(residuals)) if weights is None else weights / weights.mean()
    sigma = max(floor, 1.4826 * float(np.median(np.abs(residuals))))
    lowest = _deviance(residuals, sigma, share)
    for _ in range(max_steps):
        step = damped_step(*_equations(residuals, jacobian, sigma, share), damping)
        moved = model.transformed(state, step)
        moved_residuals, moved_jacobian = model.residuals(moved)
        if _deviance(moved_residuals, sigma, share) < lowest:
            state, residuals, jacobian = moved, moved_residuals, moved_jacobian
            sigma = _rescaled(residuals, sigma, share, floor)
            before, lowest = lowest, _deviance(residuals, sigma, share)
            damping = max(damping / 5.0, 1e-9)
            if before - lowest < CONVERGED:
                break
        else:
            damping *= 10.0
            if damping > MAX_DAMPING:
                break
    information, _ = _equations(residuals, jacobian, sigma, share)
    return Estimate(
        state=state,
        residuals=residuals,
        sigma=sigma,
        information=information / sigma**2,
        deviance=lowest,
    )


def _equations(
    residuals: Array, jacobian: Array, sigma: float, share: Array
) -> tuple[Array, Array]:
    normal, right = normal_equations(residuals, jacobian, sigma, share, DEGREES_OF_FREEDOM)
    return normal, right
