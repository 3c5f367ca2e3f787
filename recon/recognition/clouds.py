"""Recognition of any cloud: rotated upright, binned into cells, named, and transformed back."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.errors import InputError
from recon.geometry import invert, pose
from recon.recognition.cells import gather
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
    upright = cloud.select(finite).transformed(T_up_cloud)
    voxels = gathered(upright)
    found = recognise(voxels, replace(settings, ground=None), T_up_cloud @ views)
    label[finite] = _of_points(found.label, voxels, upright.points)
    T_cloud_up = invert(T_up_cloud)
    return Recognition(
        objects=tuple(moved_object(one, T_cloud_up) for one in found.objects),
        label=label,
        failures=found.failures,
        planes=tuple(moved(plane, T_cloud_up) for plane in found.planes),
    )


def gathered(cloud: PointCloud) -> Voxels:
    """Bin a cloud into cells as small as its density allows."""
    side = _cell_size(cloud.points)
    voxels = gather(cloud, side)
    if len(voxels) > MOST_CELLS:
        voxels = gather(cloud, side * float(np.sqrt(len(voxels) / MOST_CELLS)))
    enough = np.clip(round(FULL_CELL * float(np.median(voxels.counts))), 1, MIN_COUNT)
    return voxels.select(voxels.counts >= enough)


def _of_points(label: NDArray[np.int32], voxels: Voxels, points: Array) -> NDArray[np.int32]:
    """Labels (N,) of points from the labels (K,) of their cells."""
    reach = 0.51 * voxels.cell_size
    cell = cKDTree(voxels.centres).query(points, p=np.inf, distance_upper_bound=reach)[1]
    return np.append(label, np.int32(-1))[cell]


def _cell_size(points: Array) -> float:
    """Side of a cell that holds a few neighbours; 1 if all points coincide."""
    probes = points[:: max(1, len(points) // NUM_PROBES)]
    count = min(NEIGHBOURS_IN_CELL + 1, len(points))
    reach = np.asarray(cKDTree(points).query(probes, k=count)[0]).reshape(len(probes), -1)[:, -1]
    side = float(np.median(reach))
    # The indices of cells far smaller than the cloud would overflow.
    return max(side, 1e-5 * extent(points)) or 1.0
