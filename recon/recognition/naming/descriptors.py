"""Descriptors of an object's cells: its size, height profile, local surface and solids."""

from collections.abc import Callable
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from recon.libraries import load_open3d
from recon.recognition.fitting.shapes import MODELS, candidates
from recon.recognition.segments.boxes import upright_box
from recon.records import FitFailure, Voxels
from recon.settings.stage import STRICT, Positive

Array = NDArray[np.float64]

NUM_LEVELS = 8
"""Slices of the height profile."""
FINENESS = 24.0
"""Points for histograms along the longest side of an object."""
NORMAL_REACH, HISTOGRAM_REACH = 3.0, 6.0
"""Radii of neighbourhoods, in spacings of these points."""
NEIGHBOURS_OF_NORMAL, NEIGHBOURS_OF_HISTOGRAM = 20, 60
ON_SOLID = 0.03
"""A point closer than this share of the object's size is on a solid."""
NUM_DESCRIBED = 600
"""Maximum number of cells used to describe an object."""
NUM_FITTED = 300
"""Maximum number of points that solids are fitted to."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Group:
    """One group of descriptors of a kind."""

    scale: Positive
    """Typical distance of two examples of the kind."""
    examples: Annotated[tuple[tuple[float, ...], ...], Field(min_length=1)]
    """One row per example."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Learned:
    """A kind defined by examples: objects belong to it that are as close to one as these are."""

    threshold: Positive
    """Distance up to which nine of ten left-out examples are accepted."""
    groups: Annotated[dict[str, Group], Field(min_length=1)]
    """Keyed by the names of `DESCRIPTORS`."""
    unit: str | None = None
    """Unit of the sizes: "m", or None if unknown."""

    @property
    def num_examples(self) -> int:
        """Number of examples it was learned from."""
        return len(next(iter(self.groups.values())).examples)

    @property
    def ceiling(self) -> float:
        """Maximum probability for this number of examples: Laplace's rule of succession."""
        return (self.num_examples + 1) / (self.num_examples + 2)

    def believed(self, chance: float) -> float:
        """A probability above one half, scaled down to the ceiling; accepted stays accepted."""
        return min(chance, 0.5 + (2.0 * self.ceiling - 1.0) * (chance - 0.5))

    def distance(self, described: dict[str, Array]) -> float:
        """Distance of an object to the nearest example; 1 = the typical distance of examples."""
        rows = [
            np.linalg.norm(np.array(group.examples) - described[name], axis=1) / group.scale
            for name, group in self.groups.items()
        ]
        return float(np.sqrt(np.mean(np.square(rows), axis=0)).min())


def describe(voxels: Voxels) -> dict[str, Array]:
    """Every group of descriptors of an object's cells, y up."""
    if len(voxels) > NUM_DESCRIBED:
        # Histograms depend on the cell density, so all objects use the same maximum number of
        # cells.
        rows = np.random.default_rng(0).choice(len(voxels), NUM_DESCRIBED, replace=False)
        voxels = voxels.select(np.sort(rows))
    return {name: descriptor(voxels) for name, descriptor in DESCRIPTORS.items()}


def size(voxels: Voxels) -> Array:
    """Logs (3,) of height, width and depth."""
    sizes = upright_box(voxels.means).sizes + voxels.cell_size
    return np.log([sizes[1], max(sizes[0], sizes[2]), min(sizes[0], sizes[2])])


def profile(voxels: Voxels) -> Array:
    """Mean distance from the vertical axis and share of cells per slice of the height (16,)."""
    points = voxels.means
    low, high = np.quantile(points, [0.02, 0.98], axis=0)
    axis = ((low + high) / 2.0)[::2]
    height = max(float(high[1] - low[1]), voxels.cell_size)
    level = np.clip(((points[:, 1] - low[1]) / height * NUM_LEVELS).astype(int), 0, NUM_LEVELS - 1)
    rho = np.hypot(*(points[:, ::2] - axis).T) / height
    counts = np.bincount(level, minlength=NUM_LEVELS)
    radii = np.bincount(level, rho, NUM_LEVELS) / np.maximum(counts, 1)
    return np.concatenate([radii, counts / len(points)])


def surface(voxels: Voxels) -> Array:
    """Square roots of the mean fast point feature histogram (33,), Rusu 2009."""
    open3d = load_open3d()
    side = float(np.ptp(voxels.means, axis=0).max()) / FINENESS or voxels.cell_size
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(voxels.means))
    cloud = cloud.voxel_down_sample(max(side, 1e-9))
    search = open3d.geometry.KDTreeSearchParamHybrid
    cloud.estimate_normals(search(NORMAL_REACH * side, NEIGHBOURS_OF_NORMAL))
    cloud.orient_normals_towards_camera_location(cloud.get_center())
    histograms = open3d.pipelines.registration.compute_fpfh_feature(
        cloud, search(HISTOGRAM_REACH * side, NEIGHBOURS_OF_HISTOGRAM)
    ).data
    mean = np.nan_to_num(np.asarray(histograms)).mean(axis=1)
    roots: Array = np.sqrt(mean / max(float(mean.sum()), 1e-12))
    return roots


def solids(voxels: Voxels) -> Array:
    """Share of the cells on the best solid of each shape (6,)."""
    points = voxels.means
    if len(points) > NUM_FITTED:
        rows = np.random.default_rng(0).choice(len(points), NUM_FITTED, replace=False)
        points = points[rows]
    near = ON_SOLID * float(np.linalg.norm(np.ptp(points, axis=0))) + 0.25 * voxels.cell_size
    shares = dict.fromkeys(MODELS, 0.0)
    found = candidates(points)
    for one in () if isinstance(found, FitFailure) else found:
        shape = one.solid.kind.removeprefix("truncated ")
        shares[shape] = float((one.solid.distances(points) < near).mean())
    return np.array(list(shares.values()))


DESCRIPTORS: dict[str, Callable[[Voxels], Array]] = {
    "size": size,
    "profile": profile,
    "surface": surface,
    "solids": solids,
}
"""Each returns the same number of values for every object."""
USUAL_SCALES = {"size": 0.15, "profile": 0.15, "surface": 0.1, "solids": 0.5}
"""Prior for the typical distance of two examples of one kind."""
