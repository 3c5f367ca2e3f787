"""Synthetic objects as in a map: visible surface, stereo noise, heavy tails, cells.

Shared by tests, calibration and benchmarks; no images are involved.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.cells import gather
from recon.recognition.fitting.composite import Composite, solids
from recon.recognition.fitting.surface_points import Surface, surface
from recon.records import PointCloud, Solid, Voxels

Array = NDArray[np.float64]

FOCAL_PX = 152.55
FOCAL_BASELINE = 45.76
"""Focal length (pixels) times baseline (world units) of the thesis: sigma_z = z^2 / (f b)
sigma_d."""
SURFACE_POINTS = 6000
"""Surface points of an object that a camera samples from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Orbit:
    """Orbit of cameras around an object, with their noise and density."""

    num_views: int = 9
    clearance: float = 10.0
    """Distance of the cameras from the surface, world units."""
    eye_height: float = 5.0
    sigma_px: float = 0.05
    """Noise of the disparity; a tenth of the points has three times as much, 2 percent are
    outliers."""
    arc_rad: float = 2.0 * np.pi
    start_rad: float = 0.0
    """Azimuth of the first view."""
    points_per_pixel: float = 0.11
    """Features kept per pixel of the object, as for the apple tree of the village."""


def observe(
    parts: Composite | Sequence[Solid], colours: Array, orbit: Orbit, rng: np.random.Generator
) -> PointCloud:
    """The points that an orbit of stereo pairs sees of an object with some parts.

    Parameters
    ----------
    parts : Composite or sequence of Solid
        An upright composite, or the solids of any other object.
    colours : (parts, 3)
        RGB colour of each part, 0 to 255.
    """
    solid_parts = solids(parts) if isinstance(parts, Composite) else parts
    whole = surface(solid_parts, SURFACE_POINTS, rng)
    middle = (whole.points.min(axis=0) + whole.points.max(axis=0))[::2] / 2.0
    reach = float(np.hypot(*(whole.points[:, ::2] - middle).T).max()) + orbit.clearance
    angles = orbit.start_rad + np.arange(orbit.num_views) * orbit.arc_rad / orbit.num_views
    seen = []
    for angle in angles:
        place = middle + reach * np.array([np.cos(angle), np.sin(angle)])
        eye = np.array([place[0], orbit.eye_height, place[1]])
        whole = surface(solid_parts, SURFACE_POINTS, rng)
        seen.append(_seen(whole, colours, eye, orbit, rng))
    return PointCloud(
        points=np.concatenate([cloud.points for cloud in seen]),
        colours=np.concatenate([cloud.shown_colours for cloud in seen]),
    )


def _seen(
    whole: Surface, colours: Array, eye: Array, orbit: Orbit, rng: np.random.Generator
) -> PointCloud:
    ray = whole.points - eye
    # Pixels per area decrease with the square of the distance and with the slant.
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
    """The occupied cells of a cloud, including the ground."""
    return gather(cloud, cell_size, min_count)


def random_composite(kind: str, rng: np.random.Generator) -> Composite:
    """An apple tree, a pine tree or a cottage of random size and position."""
    axis = rng.uniform(-50.0, 50.0, 2)
    body = rng.uniform(4.0, 10.0)
    if kind == "apple tree":
        radius = rng.uniform(2.5, 6.0)
        return Composite(
            shapes=("cylinder", "sphere"),
            axis=axis,
            heights=np.array([0.0, body, body + 2.0 * radius]),
            radii=(np.array([radius * rng.uniform(0.25, 0.6)]), np.array([])),
        )
    base = rng.uniform(4.0, 8.0)
    share = rng.uniform(0.15, 0.4) if kind == "pine tree" else rng.uniform(0.8, 1.0)
    return Composite(
        shapes=("cylinder", "truncated cone"),
        axis=axis,
        heights=np.array([0.0, body, body + rng.uniform(0.5, 1.3) * base]),
        radii=(np.array([max(1.0, base * share)]), np.array([base, rng.uniform(0.3, 1.2)])),
    )
