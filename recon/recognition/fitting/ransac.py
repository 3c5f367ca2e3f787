"""Detection of many solids in a scene: drawn from few points, voted for by all, removed one by one.

Schnabel, Wahl, Klein, "Efficient RANSAC for point-cloud shape detection", 2007: a handful of
neighbouring points with their normals gives a plane, sphere, cylinder or cone; the points on the
best of these are fitted again, and BIC chooses among all solids.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.errors import check_finite, check_shape
from recon.recognition.connectivity import joined
from recon.recognition.fitting.draws import drawn, ranked_neighbours, solid, votes
from recon.recognition.fitting.normals import NUM_NEIGHBOURS, neighbourhoods
from recon.recognition.fitting.shapes import fit, from_points
from recon.records import FitFailure, Solid

Array = NDArray[np.float64]

NUM_DRAWS = 80
"""Draws per round; about one in ten draws of neighbouring points is on a single solid."""
NUM_VOTERS = 1500
"""Points that vote for a draw."""
MOST_SOLIDS = 32
TOLERANCE_SIGMAS = 4.0
"""Points within this number of noise scales are on a solid."""
RELATIVE_TOLERANCE = 1e-3
"""Minimum tolerance as a share of the scene, because of facets and rounding."""
LINK = 4.0
"""Maximum distance between neighbouring points of one solid, in median spacings."""


Refit = Callable[[Solid, Array], Solid | FitFailure]
"""The fit to the points on a drawn solid."""


def best_solid(rough: Solid, points: Array) -> Solid | FitFailure:
    """The solid of any shape that points on a drawn one lie on."""
    return fit(points)


def same_solid(rough: Solid, points: Array) -> Solid | FitFailure:
    """The solid of the drawn shape that points on it lie on."""
    found = from_points(rough.kind, points)
    return found if isinstance(found, FitFailure) else found.solid


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundSolid:
    """One solid of a scene."""

    solid: Solid
    rows: NDArray[np.intp]
    """Points on it."""
    rms: float


def find_solids(
    points: Array,
    min_points: int,
    rng: np.random.Generator,
    most: int = MOST_SOLIDS,
    refit: Refit = best_solid,
) -> list[FoundSolid]:
    """The solids of a scene in the order of their removal: the largest first.

    Parameters
    ----------
    points : (N, 3) float64
    min_points : int
        Minimum number of points of a solid.
    most : int
        Maximum number of solids.
    refit : Callable
        Fits the points on a drawn solid again: `best_solid`, or faster `same_solid`.

    Raises
    ------
    InputError
        If a coordinate is not finite.
    """
    check_shape("points", points, (None, 3))
    check_finite("points", points)
    rest = np.arange(len(points))
    found: list[FoundSolid] = []
    while len(rest) >= max(min_points, NUM_NEIGHBOURS) and len(found) < most:
        scene = _scene(points[rest])
        one = _largest(scene, rng, refit)
        if one is None or len(one.rows) < min_points:
            break
        found.append(FoundSolid(solid=one.solid, rows=rest[one.rows], rms=one.rms))
        rest = np.delete(rest, one.rows)
    return found


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Scene:
    """Points with properties of their neighbourhoods."""

    points: Array
    normals: Array
    spacing: float
    tolerance: float


def _scene(points: Array) -> _Scene:
    around = neighbourhoods(points)
    size = float(np.ptp(points, axis=0).max())
    sigma = float(np.median(around.thickness))
    return _Scene(
        points=points,
        normals=around.normals,
        spacing=float(np.median(around.spacing)),
        tolerance=max(TOLERANCE_SIGMAS * sigma, RELATIVE_TOLERANCE * size),
    )


def _largest(scene: _Scene, rng: np.random.Generator, refit: Refit) -> FoundSolid | None:
    """The solid with the most points on it, refined on these."""
    voters = scene.points[rng.permutation(len(scene.points))[:NUM_VOTERS]]
    size = float(np.ptp(scene.points, axis=0).max())
    rows = _draws(scene.points, rng)
    found = drawn(*map(np.ascontiguousarray, (scene.points[rows], scene.normals[rows])), size)
    counts = votes(voters, *found, scene.tolerance)
    best = np.unravel_index(int(np.argmax(counts)), counts.shape)
    if not counts[best]:
        return None
    place, axis, number = (values[best] for values in found)
    return _refined(scene, solid(int(best[1]), place, axis, float(number), size), refit)


def _draws(points: Array, rng: np.random.Generator) -> NDArray[np.int64]:
    """Rows (D, 3) of neighbouring points, in neighbourhoods of all sizes: a hole or the whole."""
    firsts = rng.integers(len(points), size=NUM_DRAWS)
    sizes = 4.0 * 2.0 ** rng.uniform(1.0, 8.0, NUM_DRAWS)
    ranks = rng.uniform(size=(NUM_DRAWS, 2)) * np.minimum(sizes, len(points))[:, None]
    rows: NDArray[np.int64] = ranked_neighbours(points, firsts, ranks.astype(np.int64))
    return rows


def _refined(scene: _Scene, rough: Solid, refit: Refit) -> FoundSolid | None:
    rows = _connected(scene, np.flatnonzero(rough.distances(scene.points) < scene.tolerance))
    best = refit(rough, scene.points[rows])
    if isinstance(best, FitFailure):
        return None
    away = best.distances(scene.points)
    rows = _connected(scene, np.flatnonzero(away < scene.tolerance))
    if not len(rows):
        return None
    return FoundSolid(solid=best, rows=rows, rms=float(np.sqrt(np.mean(away[rows] ** 2))))


def _connected(scene: _Scene, rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """The largest group of rows with connected points."""
    if not len(rows):
        return rows
    reach = LINK * scene.spacing
    _, near = cKDTree(scene.points[rows]).query(
        scene.points[rows], k=min(NUM_NEIGHBOURS, len(rows)), distance_upper_bound=reach
    )
    near = near.reshape(len(rows), -1)
    first, slot = np.nonzero(near < len(rows))
    label = joined(np.column_stack([first, near[first, slot]]), len(rows))
    largest: NDArray[np.intp] = rows[label == np.argmax(np.bincount(label))]
    return largest
