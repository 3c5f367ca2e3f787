"""Synthetic objects as a map holds them: visible surface, stereo noise, heavy tails, cells.

Tests, calibration and benchmarks share them; nothing here looks at an image.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.cells import gather
from recon.recognition.fitting.composite import Stack
from recon.records import PointCloud, Voxels

Array = NDArray[np.float64]

FOCAL_PX = 152.55
FOCAL_BASELINE = 45.76
"""Pixels times world units of the thesis's eyes: sigma_z = z^2 / (f b) sigma_d."""
SURFACE_POINTS = 6000
"""Places on an object that an eye chooses among."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Orbit:
    """Where an object is looked at from, and how well."""

    num_views: int = 9
    clearance: float = 10.0
    """Distance of the eyes from the surface, world units."""
    eye_height: float = 5.0
    sigma_px: float = 0.05
    """Of the disparity; a tenth of the points has three times as much, 2 percent are far off."""
    arc_rad: float = 2.0 * np.pi
    points_per_pixel: float = 0.11
    """Features kept on a pixel of the object: the village's apple tree has as many."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surface:
    """Points on an object with their outward normals, the part they lie on, and all its area."""

    points: Array
    normals: Array
    part: NDArray[np.intp]
    area: float


def surface(stack: Stack, num_points: int, rng: np.random.Generator) -> Surface:
    """Points spread evenly over the parts of a stack."""
    areas = _areas(stack)
    pieces = [
        _revolved(stack, part, int(num_points * share), rng)
        for part, share in enumerate(areas / areas.sum())
    ]
    part = np.repeat(np.arange(len(pieces)), [len(points) for points, _ in pieces])
    return Surface(
        points=np.concatenate([points for points, _ in pieces]),
        normals=np.concatenate([normals for _, normals in pieces]),
        part=part,
        area=float(areas.sum()),
    )


def _outline(stack: Stack, part: int) -> Array:
    """Corners (rho, y) of a part, upwards."""
    low, high = stack.heights[part : part + 2]
    radii, shape = stack.radii[part], stack.shapes[part]
    if shape in ("sphere", "ellipsoid"):
        half = (high - low) / 2.0
        angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, 65)
        radius = radii[0] if len(radii) else half
        return np.column_stack([radius * np.cos(angle), (low + high) / 2.0 + half * np.sin(angle)])
    return np.array([[radii[0], low], [radii[-1], high]])


def _bands(outline: Array) -> Array:
    """Area of each band between two corners of an outline."""
    steps = np.hypot(*np.diff(outline, axis=0).T)
    areas: Array = np.pi * steps * (outline[:-1, 0] + outline[1:, 0])
    return areas


def _areas(stack: Stack) -> Array:
    return np.array([_bands(_outline(stack, part)).sum() for part in range(len(stack.shapes))])


def _revolved(
    stack: Stack, part: int, num_points: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    outline = _outline(stack, part)
    bands = _bands(outline)
    band = rng.choice(len(bands), size=num_points, p=bands / bands.sum())
    start, along = outline[band], np.diff(outline, axis=0)[band]
    # Area grows with rho: the share along a band is drawn by the inverse of its cumulated area.
    a, b = start[:, 0], start[:, 0] + along[:, 0]
    draw = rng.uniform(size=num_points)
    rho = np.sqrt(a**2 + draw * (b**2 - a**2))
    flat = np.abs(b - a) > 1e-9
    share = np.where(flat, (rho - a) / np.where(flat, b - a, 1.0), draw)
    profile = start + share[:, None] * along
    normal = np.column_stack([along[:, 1], -along[:, 0]])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    turn = rng.uniform(0.0, 2.0 * np.pi, num_points)
    c, s = np.cos(turn), np.sin(turn)
    points = np.column_stack([profile[:, 0] * c, profile[:, 1], profile[:, 0] * s])
    points += [stack.axis[0], 0.0, stack.axis[1]]
    return points, np.column_stack([normal[:, 0] * c, normal[:, 1], normal[:, 0] * s])


def observe(stack: Stack, colours: Array, orbit: Orbit, rng: np.random.Generator) -> PointCloud:
    """What an orbit of stereo pairs sees of a stack.

    Parameters
    ----------
    colours : (parts, 3)
        RGB of each part, 0 to 255.
    """
    reach = float(stack.widest.max()) + orbit.clearance
    seen = []
    for angle in np.arange(orbit.num_views) * orbit.arc_rad / orbit.num_views:
        eye = np.array(
            [
                stack.axis[0] + reach * np.cos(angle),
                orbit.eye_height,
                stack.axis[1] + reach * np.sin(angle),
            ]
        )
        seen.append(_seen(stack, colours, eye, orbit, rng))
    return PointCloud(
        points=np.concatenate([cloud.points for cloud in seen]),
        colours=np.concatenate([cloud.shown_colours for cloud in seen]),
    )


def _seen(
    stack: Stack, colours: Array, eye: Array, orbit: Orbit, rng: np.random.Generator
) -> PointCloud:
    whole = surface(stack, SURFACE_POINTS, rng)
    ray = whole.points - eye
    # Pixels per area fall with the square of the distance, and with the slant.
    length = np.linalg.norm(ray, axis=1)
    facing = -np.einsum("ij,ij->i", whole.normals, ray) / length
    chance = np.maximum(facing, 0.0) / length**2
    num_pixels = FOCAL_PX**2 * whole.area * float(chance.mean())
    size = int(orbit.points_per_pixel * num_pixels)
    rows = rng.choice(len(ray), size=size, p=chance / chance.sum())
    sigma = length[rows] ** 2 / FOCAL_BASELINE * orbit.sigma_px
    sigma = sigma * np.where(rng.uniform(size=len(rows)) < 0.1, 3.0, 1.0)
    error = sigma * rng.standard_normal(len(rows))
    far_off = rng.uniform(size=len(rows)) < 0.02
    error = np.where(far_off, rng.uniform(-5.0, 5.0, len(rows)), error)
    points = whole.points[rows] + (error / length[rows])[:, None] * ray[rows]
    shade = colours[whole.part[rows]] + rng.normal(0.0, 12.0, (len(rows), 3))
    return PointCloud(points=points, colours=np.clip(shade, 0, 255).astype(np.uint8))


def voxelise(cloud: PointCloud, cell_size: float = 1.0, min_count: int = 5) -> Voxels:
    """The occupied cells of a cloud, the ground's included."""
    return gather(cloud, cell_size, min_count)


def random_stack(kind: str, rng: np.random.Generator) -> Stack:
    """An apple tree, a pine tree or a cottage of random size and place."""
    axis = rng.uniform(-50.0, 50.0, 2)
    body = rng.uniform(4.0, 10.0)
    if kind == "apple tree":
        radius = rng.uniform(2.5, 6.0)
        return Stack(
            shapes=("cylinder", "sphere"),
            axis=axis,
            heights=np.array([0.0, body, body + 2.0 * radius]),
            radii=(np.array([radius * rng.uniform(0.25, 0.6)]), np.array([])),
        )
    base = rng.uniform(4.0, 8.0)
    share = rng.uniform(0.15, 0.4) if kind == "pine tree" else rng.uniform(0.8, 1.0)
    return Stack(
        shapes=("cylinder", "truncated cone"),
        axis=axis,
        heights=np.array([0.0, body, body + rng.uniform(0.5, 1.3) * base]),
        radii=(np.array([max(1.0, base * share)]), np.array([base, rng.uniform(0.3, 1.2)])),
    )
