"""Curvature of planes and outlines: distances from true ones do not depend on the place."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from recon.geometry import WORLD_UP
from recon.recognition.fitting.composite import NOISE_FLOOR, Composite
from recon.recognition.fitting.least_squares import Estimate
from recon.recognition.segments.flat_pieces import FlatPiece
from recon.records import Voxels

Array = NDArray[np.float64]

RESOLVED_CELLS = 2.0
"""Radius and half height of a part, in cells, from which its cells show an outline."""
ON_OUTLINE_SIGMAS = 4.0
"""Scales of the noise within which a cell shows an outline: those at the rim of a roof do not."""
UNEVEN_CELLS = 0.1
"""Noise of an outline at least, in cells, whose means are off by as much."""
CURVE_DEGREE = 3
"""Degree of the curves that compete with an outline: it narrows, and bulges at one end."""


def bend(cells: Voxels, walls: Sequence[FlatPiece]) -> float:
    """BIC per cell by which quadratic surfaces explain upright planes better than planes."""
    least = NOISE_FLOOR * cells.cell_size
    gains = [_gain(cells.means[wall.rows], least) for wall in walls]
    return sum(gains) / max(1, sum(len(wall.rows) for wall in walls))


def bend_of_outlines(fit: Estimate[Composite], cells: Voxels) -> float:
    """BIC per cell by which curves of the height explain the outlines of parts better."""
    composite, least = fit.state, UNEVEN_CELLS * cells.cell_size
    signed, part = composite.nearest(cells.means)
    rises = np.diff(composite.heights)
    is_resolved = np.minimum(composite.widest, rises / 2.0) > RESOLVED_CELLS * cells.cell_size
    on_it = np.abs(signed) < max(ON_OUTLINE_SIGMAS * fit.sigma, least)
    gain, count = 0.0, 0
    for number in np.flatnonzero(is_resolved):
        own = (part == number) & on_it
        along = (cells.means[own, 1] - composite.heights[number]) / rises[number]
        curves = np.vander(np.clip(along, 0.0, 1.0) - 0.5, CURVE_DEGREE + 1)
        none = np.empty((len(curves), 0))
        gain += max(0.0, _bic_gain(none, curves, signed[own], least))
        count += int(own.sum())
    return gain / max(count, 1)


def _gain(points: Array, least: float) -> float:
    """BIC by which a quadratic surface explains points (N, 3) on an upright plane better."""
    offsets = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(offsets[:, ::2], full_matrices=False)
    along, away = (offsets[:, ::2] @ axes.T).T
    up = offsets @ WORLD_UP
    flat = np.column_stack([np.ones(len(points)), along, up])
    curved = np.column_stack([flat, along**2, along * up, up**2])
    return _bic_gain(flat, curved, away, least)


def _bic_gain(terms: Array, more: Array, values: Array, least: float) -> float:
    """BIC by which combinations of more terms (N, M) explain values (N,) than those of some."""
    if len(values) <= more.shape[1]:
        return 0.0
    variances = [_variance(each, values) + least**2 for each in (terms, more)]
    spare = more.shape[1] - terms.shape[1]
    gain: float = len(values) * np.log(variances[0] / variances[1]) - spare * np.log(len(values))
    return gain


def _variance(terms: Array, values: Array) -> float:
    """Variance of values (N,) about their best linear combination of terms (N, K)."""
    rest = values - terms @ np.linalg.lstsq(terms, values, rcond=None)[0]
    return float(np.mean(rest**2))
