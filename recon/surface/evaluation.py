"""Accuracy and completeness of a surface compared with the true one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.errors import InputError
from recon.libraries import load_open3d
from recon.records import Mesh

Array = NDArray[np.float64]

_ACCURACY_SHARE = 0.9


@dataclass(frozen=True, slots=True, kw_only=True)
class SurfaceEvaluation:
    """Metrics of one surface compared with the truth."""

    accuracy_90: float
    """Distance to the truth within which nine of ten points of the surface lie, world units."""
    completeness: float
    """Share of the truth within the median of the given distances from the surface."""
    precision: dict[float, float]
    """Share of the surface within a distance of the truth, by distance."""
    recall: dict[float, float]
    """Share of the truth within a distance of the surface, by distance."""
    fscore: dict[float, float]
    """Harmonic mean of precision and recall, by distance."""

    def as_metrics(self) -> dict[str, Any]:
        """The metrics by name, with distances as text."""
        tables = {
            name: {f"{distance:g}": value for distance, value in getattr(self, name).items()}
            for name in ("precision", "recall", "fscore")
        }
        return {"accuracy_90": self.accuracy_90, "completeness": self.completeness, **tables}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Judged:
    """A surface to be compared: points on it, and its triangles if it has any."""

    points: Array
    """(N, 3)"""
    mesh: Mesh | None = None

    def distance(self, points: Array) -> Array:
        """(M,) distance of points (M, 3) to the surface."""
        return _to_points(points, self.points) if self.mesh is None else _to_mesh(points, self.mesh)


def judge(found: Judged, truth: Judged, distances: Sequence[float]) -> SurfaceEvaluation:
    """Compare a surface with the true one.

    Parameters
    ----------
    found, truth : Judged
        The points of the truth may cover only the visible part of its mesh.
    distances : sequence of float
        World units.

    Raises
    ------
    InputError
        If one of the two is empty.
    """
    for name, one in (("the surface", found), ("the truth", truth)):
        if not len(one.points):
            raise InputError(f"{name} has no points, but at least one is needed")
    to_truth, to_found = truth.distance(found.points), found.distance(truth.points)
    precision = {float(d): _share_within(to_truth, d) for d in distances}
    recall = {float(d): _share_within(to_found, d) for d in distances}
    middle = sorted(recall)[len(recall) // 2]
    return SurfaceEvaluation(
        accuracy_90=float(np.quantile(to_truth, _ACCURACY_SHARE)),
        completeness=recall[middle],
        precision=precision,
        recall=recall,
        fscore={d: _harmonic(precision[d], recall[d]) for d in precision},
    )


def _share_within(distance: Array, limit: float) -> float:
    return float(np.mean(distance <= limit))


def _harmonic(a: float, b: float) -> float:
    return 2 * a * b / (a + b) if a + b > 0 else 0.0


def _to_points(points: Array, others: Array) -> Array:
    """(N,) distance of points to the nearest of others."""
    distance: Array = np.asarray(cKDTree(others).query(points)[0])
    return distance


def _to_mesh(points: Array, mesh: Mesh) -> Array:
    """(N,) distance of points to the nearest triangle."""
    core = load_open3d().core
    scene = load_open3d().t.geometry.RaycastingScene()
    # Relative to the centre of the mesh, 32 bits are precise enough.
    middle = mesh.vertices.mean(axis=0)
    scene.add_triangles(
        core.Tensor((mesh.vertices - middle).astype(np.float32)),
        core.Tensor(mesh.triangles.astype(np.uint32)),
    )
    queries = core.Tensor((points - middle).astype(np.float32))
    distance: Array = scene.compute_distance(queries).numpy().astype(np.float64)
    return distance
