"""Recognition of any cloud: levelled, gathered into cells, named, and brought back."""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.errors import InputError
from recon.geometry import invert, pose, transform
from recon.recognition.cells import gather
from recon.recognition.recognition import recognise
from recon.recognition.segments.ground import extent, level_plane
from recon.records import FoundObject, Part, PointCloud, Recognition, Solid
from recon.settings import RecognitionSettings

Array = NDArray[np.float64]
Up = Literal["y", "-y", "z", "-z"]

T_LEVEL_CLOUD: Mapping[str, Array] = {
    "y": np.eye(4),
    "-y": np.diag([1.0, -1.0, -1.0, 1.0]),
    "z": pose([[1, 0, 0], [0, 0, 1], [0, -1, 0]], [0, 0, 0]),
    "-z": pose([[1, 0, 0], [0, 0, -1], [0, 1, 0]], [0, 0, 0]),
}
"""Turns a cloud so that its own direction of `up` is y."""

NEIGHBOURS_IN_CELL = 8
"""Nearest neighbours that a cell of a cloud should hold."""
NUM_PROBES = 2000
MIN_COUNT = 3
"""Points of an occupied cell of a cloud."""
CLEARANCE_CELLS = 1.5
"""Cells lower over the plane than this belong to it."""


def recognise_cloud(cloud: PointCloud, settings: RecognitionSettings, up: Up = "y") -> Recognition:
    """Find and name the objects of a cloud that stand on its largest level plane.

    Parameters
    ----------
    cloud : PointCloud
        In any frame and unit.
    settings : RecognitionSettings
        `ground` is used where the cloud shows no level plane.
    up : str
        The cloud's axis that points up, to within the tilt of a hand-held camera.

    Returns
    -------
    Recognition
        In the frame of the cloud, sizes across and along the plane's normal; `label` has one
        number a point.

    Raises
    ------
    InputError
        Where `up` is none of the four.
    """
    if up not in T_LEVEL_CLOUD:
        raise InputError(f"up is {up!r}, but one of {', '.join(T_LEVEL_CLOUD)} is needed")
    finite = np.flatnonzero(np.isfinite(cloud.points).all(axis=1))
    label = np.full(len(cloud), -1, dtype=np.int32)
    if not len(finite):
        reason = {"no finite point": 1} if len(cloud) else {}
        return Recognition(objects=(), label=label, failures=reason)
    level = cloud.select(finite).transformed(T_LEVEL_CLOUD[up])
    T_floor_level = level_plane(level.points)
    on_plane = T_floor_level is not None
    T_floor_cloud = (np.eye(4) if T_floor_level is None else T_floor_level) @ T_LEVEL_CLOUD[up]
    found, label[finite] = _on_floor(
        cloud.select(finite).transformed(T_floor_cloud), settings, on_plane
    )
    T_cloud_floor = invert(T_floor_cloud)
    return Recognition(
        objects=tuple(_moved_object(one, T_cloud_floor) for one in found.objects),
        label=label,
        failures=found.failures,
    )


def _on_floor(
    cloud: PointCloud, settings: RecognitionSettings, on_plane: bool
) -> tuple[Recognition, NDArray[np.int32]]:
    """What stands on the floor y = 0, or on the set ground, and a label for each point."""
    voxels = gather(cloud, _cell_size(cloud.points), MIN_COUNT)
    clearance = CLEARANCE_CELLS * voxels.cell_size
    lowest = float(cloud.points[:, 1].min())
    height = lowest if settings.ground is None else settings.ground
    ground = 0.0 if on_plane else height
    found = recognise(voxels, replace(settings, ground=ground, ground_clearance=clearance))
    reach = 0.51 * voxels.cell_size
    cell = cKDTree(voxels.centres).query(cloud.points, p=np.inf, distance_upper_bound=reach)[1]
    label = np.append(found.label, np.int32(-1))[cell]
    return found, label


def _cell_size(points: Array) -> float:
    """Side of a cell that holds a few neighbours; 1 where all points are one."""
    probes = points[:: max(1, len(points) // NUM_PROBES)]
    count = min(NEIGHBOURS_IN_CELL + 1, len(points))
    reach = np.asarray(cKDTree(points).query(probes, k=count)[0]).reshape(len(probes), -1)[:, -1]
    side = 2.0 * float(np.median(reach))
    # Cells far below the cloud's size would overflow their numbers.
    return max(side, 1e-5 * extent(points)) or 1.0


def _moved_object(found: FoundObject, T: Array) -> FoundObject:
    parts = tuple(_moved_part(part, T) for part in found.parts)
    return replace(found, centre=transform(T, found.centre[None])[0], parts=parts)


def _moved_part(part: Part, T: Array) -> Part:
    return replace(part, solid=transformed(part.solid, T))


def transformed(solid: Solid, T_target_source: Array) -> Solid:
    """The same solid in another frame."""
    changes: dict[str, Any] = {}
    for field in fields(solid):
        value = getattr(solid, field.name)
        if field.name in ("centre", "point", "apex"):
            changes[field.name] = transform(T_target_source, value[None])[0]
        elif field.name in ("axis", "normal", "axes"):
            changes[field.name] = value @ T_target_source[:3, :3].T
    return replace(solid, **changes)
