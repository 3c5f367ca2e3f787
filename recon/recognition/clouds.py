"""Recognition of any cloud: rotated upright, binned into cells, named, and transformed back."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.errors import InputError
from recon.geometry import invert, pose
from recon.recognition.cells import distinct, gather_points
from recon.recognition.frames import moved, moved_object
from recon.recognition.recognition import recognise
from recon.recognition.segments.ground import extent
from recon.records import PointCloud, Recognition, Voxels
from recon.settings import RecognitionSettings

Array = NDArray[np.float64]
Up = Literal["y", "-y", "z", "-z"]

T_LEVEL_CLOUD: Mapping[str, Array] = {
    "y": np.eye(4),
    "-y": np.diag([1.0, -1.0, -1.0, 1.0]),
    "z": pose([[1, 0, 0], [0, 0, 1], [0, -1, 0]], [0, 0, 0]),
    "-z": pose([[1, 0, 0], [0, 0, -1], [0, 1, 0]], [0, 0, 0]),
}
"""Transforms from a cloud with each `up` direction to a frame with y up."""

NEIGHBOURS_IN_CELL = 8
"""A cell is as wide as the distance of a point to this neighbour."""
NUM_PROBES = 2000
MOST_PROBED = 200_000
"""Points from which the density of a large cloud is estimated."""
MOST_CELLS = 20_000
"""Approximate maximum number of cells of a cloud: dense clouds get larger cells."""
FULL_CELL = 0.25
"""Points of an occupied cell, relative to the median cell ..."""
MIN_COUNT = 3
"""... but this number is always enough."""


def recognise_cloud(
    cloud: PointCloud,
    settings: RecognitionSettings,
    up: Up = "y",
    T_cloud_left: Array | None = None,
) -> Recognition:
    """Find and name the objects of a cloud.

    Parameters
    ----------
    cloud : PointCloud
        In any frame and unit.
    settings : RecognitionSettings
    up : str
        The cloud's axis that points up, within the tilt of a hand-held camera.
    T_cloud_left : (V, 4, 4) float64, optional
        Poses of its views; by default a single view from the origin of its frame.

    Returns
    -------
    Recognition
        In the frame of the cloud, with sizes measured across and along the normal of the largest
        level plane; `label` has one entry per point.

    Raises
    ------
    InputError
        If `up` is not one of the four.
    """
    if up not in T_LEVEL_CLOUD:
        raise InputError(f"up is {up!r}, but one of {', '.join(T_LEVEL_CLOUD)} is needed")
    finite = np.flatnonzero(np.isfinite(cloud.points).all(axis=1))
    label = np.full(len(cloud), -1, dtype=np.int32)
    if not len(finite):
        reason = {"no finite point": 1} if len(cloud) else {}
        return Recognition(objects=(), label=label, failures=reason)
    T_up_cloud = T_LEVEL_CLOUD[up]
    views = np.eye(4)[None] if T_cloud_left is None else T_cloud_left
    upright = (cloud if len(finite) == len(cloud) else cloud.select(finite)).transformed(T_up_cloud)
    cells = gather_points(upright, cell_size(upright.points))
    full = _is_full(cells.voxels)
    found = recognise(cells.voxels.select(full), replace(settings, ground=None), T_up_cloud @ views)
    own = np.full(len(full), -1, dtype=np.int32)
    own[full] = found.label
    label[finite] = cells.of_points(own)
    T_cloud_up = invert(T_up_cloud)
    return Recognition(
        objects=tuple(moved_object(one, T_cloud_up) for one in found.objects),
        label=label,
        failures=found.failures,
        planes=tuple(moved(plane, T_cloud_up) for plane in found.planes),
    )


def gathered(cloud: PointCloud) -> Voxels:
    """Bin a cloud into cells as small as its density allows."""
    voxels = gather_points(cloud, cell_size(cloud.points)).voxels
    return voxels.select(_is_full(voxels))


def _is_full(voxels: Voxels) -> NDArray[np.bool_]:
    """(K,) which cells hold enough points to be believed."""
    enough = np.clip(round(FULL_CELL * float(np.median(voxels.counts))), 1, MIN_COUNT)
    full: NDArray[np.bool_] = voxels.counts >= enough
    return full


def cell_size(points: Array) -> float:
    """Side of cells that hold a few neighbours each, and of which there are not too many.

    Of a large cloud a part tells it: on a surface that lies less densely by the root of its share.
    """
    few = points[:: max(1, -(-len(points) // MOST_PROBED))]
    side = _spacing(few) * float(np.sqrt(len(few) / len(points)))
    count = len(distinct(np.floor(few / side).astype(np.int64))[0])
    return side * max(1.0, float(np.sqrt(count / MOST_CELLS)))


def _spacing(points: Array) -> float:
    """Distance of a point to the last of a few neighbours; 1 where all points are one."""
    probes = points[:: max(1, len(points) // NUM_PROBES)]
    count = min(NEIGHBOURS_IN_CELL + 1, len(points))
    reach = np.asarray(cKDTree(points).query(probes, k=count)[0]).reshape(len(probes), -1)[:, -1]
    side = float(np.median(reach))
    # The indices of cells far smaller than the cloud would overflow.
    return max(side, 1e-5 * extent(points)) or 1.0
