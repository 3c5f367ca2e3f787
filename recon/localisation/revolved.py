"""Revolved: solids of revolution in the form in which they are drawn, and their texels."""

from collections.abc import Iterator, Sequence

import numpy as np

from recon.geometry import Array
from recon.localisation.drawing import Solids
from recon.recognition.fitting.axes import across_axis
from recon.recognition.fitting.surface_points import outline
from recon.records import Cone, Cylinder, Ellipsoid, Solid, Sphere, TruncatedCone

ROUND = Sphere | Ellipsoid | Cylinder | Cone | TruncatedCone


def revolved(solids: Sequence[Solid], side: float) -> Solids:
    """Solids with texels of a side, world units."""
    found = [_revolved(solid) for solid in solids]
    origin, frame, radius_sq, ends = (np.array(values) for values in zip(*found, strict=True))
    widest = np.array([_radii(*one, 100)[1].max() for one in zip(radius_sq, ends, strict=True)])
    around = np.maximum(8, np.ceil(2.0 * np.pi * widest / side))
    along = np.maximum(2, np.ceil(np.ptp(ends, axis=1) / side))
    shape = np.column_stack([around, along]).astype(np.int64)
    number = shape.prod(axis=1)
    return Solids(
        origin=origin, frame=frame, radius_sq=radius_sq, ends=ends,
        reach=np.hypot(widest, np.abs(ends).max(axis=1)),
        shape=shape, start=np.cumsum(number) - number,
    )  # fmt: skip


def _revolved(solid: Solid) -> tuple[Array, Array, Array, Array]:
    """Origin, frame, squared radius and ends of a solid, as `Solids` has them."""
    origin, axis, profile = outline(solid)
    frame = np.vstack([across_axis(axis), axis])
    if isinstance(solid, Sphere | Ellipsoid):
        half, radius = profile[-1, 0], profile[:, 1].max()
        polynomial = np.array([radius**2, 0.0, -((radius / half) ** 2)])
    else:
        (start, first), (end, last) = profile
        slope = (last - first) / (end - start)
        base = first - slope * start
        polynomial = np.array([base**2, 2.0 * base * slope, slope**2])
    return origin, frame, polynomial, profile[[0, -1], 0]


def _radii(radius_sq: Array, ends: Array, number: int) -> tuple[Array, Array]:
    """Middles of so many bands along an axis, and the radii there."""
    share = (np.arange(number) + 0.5) / number
    t = ends[0] + share * (ends[1] - ends[0])
    return t, np.sqrt(np.maximum(radius_sq @ [np.ones(number), t, t**2], 1e-12))


def texels(solids: Solids) -> Iterator[tuple[Array, Array]]:
    """Points and outward normals (K, 3) of the texels of each solid."""
    for s, (around, along) in enumerate(solids.shape):
        t, radius = _radii(solids.radius_sq[s], solids.ends[s], along)
        turn = (np.arange(around) + 0.5) * 2.0 * np.pi / around
        rise = solids.radius_sq[s, 1] / 2.0 + solids.radius_sq[s, 2] * t
        across = np.stack([np.cos(turn), np.sin(turn)], axis=1)[:, None] * radius[:, None]
        points = np.concatenate([across, np.broadcast_to(t[:, None], (around, along, 1))], axis=2)
        normals = np.concatenate(
            [across, np.broadcast_to(-rise[:, None], (around, along, 1))], axis=2
        ).reshape(-1, 3)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        yield (
            points.reshape(-1, 3) @ solids.frame[s] + solids.origin[s],
            normals @ solids.frame[s],
        )
