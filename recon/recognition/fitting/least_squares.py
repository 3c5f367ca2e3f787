"""Robust non-linear least squares: maximum likelihood under Student-t noise.

Stereo noise has heavy tails, so residuals are assumed to be Student-t distributed; the scale is
estimated with the parameters (expectation maximisation), the steps are Levenberg-Marquardt steps.
"""

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.descent import NUM_RESCALINGS, descend, descents
from recon.recognition.fitting.student import DEGREES_OF_FREEDOM, deviance, rescaled

Array = NDArray[np.float64]
State = TypeVar("State")
Other = TypeVar("Other")

NO_PARTS: NDArray[np.int64] = np.empty((2, 0), dtype=np.int64)
"""Layout of a surface that is not a composite."""
MOST_STEPS = 30


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

    def as_of(self, state: Other) -> "Estimate[Other]":
        """The same estimate with its state in another form."""
        return Estimate(
            state=state,
            residuals=self.residuals,
            sigma=self.sigma,
            information=self.information,
            deviance=self.deviance,
        )

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
    surface: int,
    points: Array,
    start: Array,
    *,
    share: Array,
    floor: float,
    layout: NDArray[np.int64] = NO_PARTS,
) -> Estimate[Array]:
    """Fit a surface to points from a start.

    Parameters
    ----------
    surface : int
        Number of the surface in `descent`.
    points : (N, 3) float64
    start : (S,) float64
        Numbers of the surface.
    share : (N,) float64
        How much each point counts, 1 on average.
    floor : float
        Minimum noise, in the unit of the residuals; > 0.
    layout : (2, parts) int64, optional
        Of a composite.
    """
    numbers, residuals, sigma, normal, lowest = descend(
        surface, points, start, layout, share, floor, MOST_STEPS
    )
    return Estimate(
        state=numbers,
        residuals=residuals,
        sigma=sigma,
        information=normal / sigma**2,
        deviance=lowest,
    )


def most_promising(
    surface: int,
    points: Array,
    starts: Array,
    *,
    share: Array,
    floor: float,
    layout: NDArray[np.int64] = NO_PARTS,
    num_steps: int,
) -> Array:
    """Numbers (S,) of the likeliest surface a few steps from starts (M, S)."""
    if len(starts) == 1:
        found: Array = starts[0]
        return found
    states, lowest = descents(surface, points, starts, layout, share, floor, num_steps)
    best: Array = states[min(range(len(states)), key=lowest.__getitem__)]
    return best
