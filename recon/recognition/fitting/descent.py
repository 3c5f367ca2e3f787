"""Descent to the most likely surface, compiled: damped steps under Student-t noise."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.fitting.distances import (
    to_box,
    to_ellipsoid,
    to_line,
    to_plane,
    to_sphere,
)
from recon.recognition.fitting.profiles import to_parts
from recon.recognition.fitting.steps import (
    moved_box,
    moved_composite,
    moved_ellipsoid,
    moved_line,
    moved_plane,
    moved_sphere,
)
from recon.recognition.fitting.student import (
    DEGREES_OF_FREEDOM,
    damped_step,
    deviance,
    normal_equations,
    rescaled,
)

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

PLANE, SPHERE, ELLIPSOID, CYLINDER, CONE, BOX, COMPOSITE = range(7)
"""Surfaces that can be fitted."""
STEP_SIZES = (3, 4, 9, 5, 6, 9)
"""Numbers of a step of each but the last."""
CONVERGED = 1e-2
"""A step that lowers -2 log likelihood by less than this has arrived."""
NUM_RESCALINGS = 3
MAX_DAMPING = 1e3


@njit(cache=True)
def descend(
    surface: int,
    points: Array,
    start: Array,
    layout: Numbers,
    share: Array,
    floor: float,
    max_steps: int,
) -> tuple[Array, Array, float, Array, float]:
    """Follow the likelihood up from a start to the most likely surface.

    Parameters
    ----------
    surface : int
        `PLANE` and so on.
    points : (N, 3)
    start : (S,) numbers of the surface
    layout : (2, parts) int64
        Outlines and counts of radii of a composite, as `to_parts` has them; else of no part.
    share : (N,) how much each point counts
    floor : float
        Smallest noise believed.

    Returns
    -------
    state : (S,)
    residuals : (N,)
    sigma : float
    normal : (P, P) normal matrix at the state
    lowest : float
        Deviance there.
    """
    state, damping, freedom = start.copy(), 1e-3, DEGREES_OF_FREEDOM
    residuals, jacobian = _residuals(surface, points, state, layout)
    sigma = max(floor, 1.4826 * np.median(np.abs(residuals)))
    lowest = deviance(residuals, sigma, share, freedom)
    normal, right = normal_equations(residuals, jacobian, sigma, share, freedom)
    for _ in range(max_steps):
        moved = _moved(surface, state, damped_step(normal, right, damping), layout.shape[1])
        others, slopes = _residuals(surface, points, moved, layout)
        if deviance(others, sigma, share, freedom) < lowest:
            state, residuals = moved, others
            sigma = rescaled(residuals, sigma, share, floor, freedom, NUM_RESCALINGS)
            before, lowest = lowest, deviance(residuals, sigma, share, freedom)
            normal, right = normal_equations(residuals, slopes, sigma, share, freedom)
            damping = max(damping / 5.0, 1e-9)
            if before - lowest < CONVERGED:
                break
        else:
            damping *= 10.0
            if damping > MAX_DAMPING:
                break
    return state, residuals, sigma, normal, lowest


@njit(cache=True)
def descents(
    surface: int,
    points: Array,
    starts: Array,
    layout: Numbers,
    share: Array,
    floor: float,
    max_steps: int,
) -> tuple[Array, Array]:
    """States (M, S) after a few steps from each start, and their deviances (M,)."""
    states, lowest = np.empty(starts.shape), np.empty(len(starts))
    for k in range(len(starts)):
        states[k], _, _, _, lowest[k] = descend(
            surface, points, starts[k], layout, share, floor, max_steps
        )
    return states, lowest


@njit(cache=True)
def _residuals(surface: int, points: Array, state: Array, layout: Numbers) -> tuple[Array, Array]:
    """Signed distances (N,) and their derivatives (N, P) by a step."""
    if surface == COMPOSITE:
        ends = 3 + layout.shape[1]
        signed, jacobian, _ = to_parts(
            points, state[:2], state[2:ends], layout[0], state[ends:], layout[1]
        )
        return signed, jacobian
    signed, jacobian = np.empty(len(points)), np.empty((STEP_SIZES[surface], len(points))).T
    if surface == PLANE:
        to_plane(points, state, signed, jacobian)
    elif surface == SPHERE:
        to_sphere(points, state, signed, jacobian)
    elif surface == ELLIPSOID:
        to_ellipsoid(points, state, signed, jacobian)
    elif surface == BOX:
        to_box(points, state, signed, jacobian)
    else:
        to_line(points, state, signed, jacobian)
    return signed, jacobian


@njit(cache=True)
def _moved(surface: int, state: Array, step: Array, num_parts: int) -> Array:
    """The state after a step."""
    moved: Array
    if surface == PLANE:
        moved = moved_plane(state, step)
    elif surface == SPHERE:
        moved = moved_sphere(state, step)
    elif surface == ELLIPSOID:
        moved = moved_ellipsoid(state, step)
    elif surface == BOX:
        moved = moved_box(state, step)
    elif surface == COMPOSITE:
        moved = moved_composite(state, step, num_parts)
    else:
        moved = moved_line(state, step)
    return moved
