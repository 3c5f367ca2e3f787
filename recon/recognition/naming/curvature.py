"""Curvature of planes: distances from a flat wall do not depend on the place on it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from recon.geometry import WORLD_UP
from recon.recognition.fitting.composite import NOISE_FLOOR
from recon.recognition.segments.flat_pieces import FlatPiece
from recon.records import Voxels

Array = NDArray[np.float64]


def bend(cells: Voxels, walls: Sequence[FlatPiece]) -> float:
    """BIC per cell by which quadratic surfaces explain upright planes better than planes."""
    least = NOISE_FLOOR * cells.cell_size
    gains = [_gain(cells.means[wall.rows], least) for wall in walls]
    return sum(gains) / max(1, sum(len(wall.rows) for wall in walls))


def _gain(points: Array, least: float) -> float:
    """BIC by which a quadratic surface explains points (N, 3) on an upright plane better."""
    offsets = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(offsets[:, ::2], full_matrices=False)
    along, away = (offsets[:, ::2] @ axes.T).T
    up = offsets @ WORLD_UP
    flat = np.column_stack([np.ones(len(points)), along, up])
    curved = np.column_stack([flat, along**2, along * up, up**2])
    variances = [_variance(terms, away) + least**2 for terms in (flat, curved)]
    bends = curved.shape[1] - flat.shape[1]
    gain: float = len(points) * np.log(variances[0] / variances[1]) - bends * np.log(len(points))
    return gain


def _variance(terms: Array, values: Array) -> float:
    """Variance of values (N,) about their best linear combination of terms (N, K)."""
    rest = values - terms @ np.linalg.lstsq(terms, values, rcond=None)[0]
    return float(np.mean(rest**2))
