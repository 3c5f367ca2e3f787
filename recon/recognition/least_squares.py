"""Robust non-linear least squares: maximum likelihood under Student-t noise.

Stereo noise has heavy tails, so residuals are taken as Student-t distributed; the scale is
estimated with the parameters (expectation maximisation), the step is Levenberg-Marquardt's.
"""

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
State = TypeVar("State")

DEGREES_OF_FREEDOM = 3.0
"""Of the Student-t noise: low enough that a tenth of gross outliers does not move a fit."""
CONVERGED = 1e-3
"""A step that lowers -2 log likelihood by less than this has arrived."""
MAX_DAMPING = 1e3


class Model(Protocol[State]):
    """What is fitted: how far the points are off, and how a step changes the parameters."""

    def residuals(self, state: State) -> tuple[Array, Array]:
        """Signed distances (N,) and their derivatives (N, P) by a step."""
        ...

    def moved(self, state: State, step: Array) -> State:
        """The state after a step (P,)."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Estimate(Generic[State]):
    """The most likely state, and how likely it is."""

    state: State
    residuals: Array
    """(N,) signed distances."""
    sigma: float
    """Scale of the Student-t noise."""
    covariance: Array
    """(P, P) of a step from the state."""
    deviance: float
    """Minus twice the log likelihood, up to a constant."""

    @property
    def bic(self) -> float:
        """Bayesian information criterion; the smallest is best."""
        return self.deviance + len(self.covariance) * float(np.log(len(self.residuals)))


def _deviance(residuals: Array, sigma: float, share: Array) -> float:
    squares = (residuals / sigma) ** 2
    tails = float(share @ np.log1p(squares / DEGREES_OF_FREEDOM))
    return (DEGREES_OF_FREEDOM + 1.0) * tails + 2.0 * len(residuals) * float(np.log(sigma))


def _weights(residuals: Array, sigma: float, share: Array) -> Array:
    """Weight of each residual in a step: its share, less the further off it is."""
    tails = DEGREES_OF_FREEDOM + (residuals / sigma) ** 2
    weights: Array = share * (DEGREES_OF_FREEDOM + 1.0) / tails
    return weights


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
        Smallest noise believed, in the unit of the residuals; above 0.
    weights : (N,) float64, optional
        How much each residual counts, whatever their scale; by default alike.
    max_steps : int
        Bound of the work.
    """
    state, damping = start, 1e-3
    residuals, jacobian = model.residuals(state)
    share = np.ones(len(residuals)) if weights is None else weights / weights.mean()
    sigma = max(floor, 1.4826 * float(np.median(np.abs(residuals))))
    for _ in range(max_steps):
        step = _damped_step(residuals, jacobian, _weights(residuals, sigma, share), damping)
        moved = model.moved(state, step)
        moved_residuals, moved_jacobian = model.residuals(moved)
        gain = _deviance(residuals, sigma, share) - _deviance(moved_residuals, sigma, share)
        if gain > 0:
            state, residuals, jacobian = moved, moved_residuals, moved_jacobian
            variance = np.mean(_weights(residuals, sigma, share) * residuals**2)
            sigma = max(floor, float(np.sqrt(variance)))
            damping = max(damping / 5.0, 1e-9)
        else:
            damping *= 10.0
        if 0 <= gain < CONVERGED or damping > MAX_DAMPING:
            break
    information = (jacobian * _weights(residuals, sigma, share)[:, None]).T @ jacobian
    covariance = sigma**2 * np.linalg.pinv(information, hermitian=True)
    return Estimate(
        state=state,
        residuals=residuals,
        sigma=sigma,
        covariance=covariance.astype(np.float64),
        deviance=_deviance(residuals, sigma, share),
    )


def _damped_step(residuals: Array, jacobian: Array, weights: Array, damping: float) -> Array:
    weighted = jacobian * weights[:, None]
    normal = weighted.T @ jacobian
    diagonal = np.diag(normal)
    normal = normal + np.diag(damping * diagonal + 1e-12 * diagonal.max() + 1e-300)
    step = -np.linalg.solve(normal, weighted.T @ residuals)
    return step.astype(np.float64)
