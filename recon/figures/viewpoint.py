"""Viewpoints of 3D figures: named views, the recording's own, or six numbers."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError
from recon.geometry import look_at

Array = NDArray[np.float64]
Box = tuple[Array, Array]
"""Lowest and highest corner (3,) of the viewed box, world."""

DIRECTIONS = {
    "default": (0.55, 0.75, 1.0),
    "front": (0.0, 0.0, 1.0),
    "back": (0.0, 0.0, -1.0),
    "side": (1.0, 0.0, 0.0),
    "top": (0.0, 1.0, 1e-9),
}
"""Directions from the centre of the box to the camera; z points at the reader."""
FLAT = ("front", "back", "side", "top")
"""Views in parallel projection, so that lengths can be measured."""
FROM_CAMERA = ("ego", "camera")
"""Views from behind the first camera, and from it."""
VIEWS = (*DIRECTIONS, *FROM_CAMERA)

VIEW_ANGLE_DEG = 28.0
EGO_ANGLE_DEG = 42.0
EGO_RISE = 0.42
"""Height of the viewpoint behind the camera, relative to its distance."""
CAMERA_ANGLE_DEG = 60.0
FRAME = 1.08
"""Margin around the box, for names and numbers."""
FLAT_FRAME = 1.18
LARGEST = float(np.sqrt(np.finfo(np.float32).max))
"""Largest coordinate whose square VTK can represent."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Viewpoint:
    """A camera of a figure: x right, y down, z forward, as everywhere in recon."""

    T_world_cam: Array
    """(4, 4)"""
    angle_deg: float = VIEW_ANGLE_DEG
    """Vertical field of view."""
    half_height: float | None = None
    """Half the height of a parallel projection, world units; None = perspective."""

    def project(self, points: ArrayLike, size: tuple[int, int]) -> Array:
        """Columns, rows and depths (N, 3) of points (N, 3) in an image of `size` pixels."""
        local = (np.asarray(points) - self.T_world_cam[:3, 3]) @ self.T_world_cam[:3, :3]
        depth = local[:, 2:]
        half = self.half_height or np.tan(np.radians(self.angle_deg) / 2.0) * depth
        with np.errstate(divide="ignore", invalid="ignore"):
            at = local[:, :2] / half * (size[1] / 2.0) + np.array(size) / 2.0
        return np.column_stack([at, depth])

    def pixels_per_unit(self, depth: Array, size: tuple[int, int]) -> Array:
        """Pixels (N,) per world unit at depths (N,)."""
        half = self.half_height or np.tan(np.radians(self.angle_deg) / 2.0) * depth
        return np.broadcast_to(size[1] / 2.0 / half, depth.shape)


def viewpoint(view: str, box: Box, size: tuple[int, int], first: Array | None = None) -> Viewpoint:
    """The camera of a view, as close as possible with the whole box visible.

    Parameters
    ----------
    view : str
        One of VIEWS, or "x,y,z" (a position that looks at the centre), or "x,y,z,x,y,z" (a position
        and a target).
    box : (low, high)
        Corners (3,) of the viewed box.
    size : (width, height)
        Of the image, pixels.
    first : (4, 4), optional
        `T_world_left` of the first camera, for "ego" and "camera".

    Raises
    ------
    InputError
        For an unknown view, and for a camera's view if there is no camera.
    """
    check(view)
    if view in DIRECTIONS:
        return framed(np.array(DIRECTIONS[view]), box, size, is_flat=view in FLAT)
    if view not in FROM_CAMERA:
        return _placed(view, box)
    if first is None:
        raise InputError(f"view is {view!r}, but there is no camera")
    if view == "camera":
        return Viewpoint(T_world_cam=first, angle_deg=CAMERA_ANGLE_DEG)
    behind = -first[:3, 2] * (1.0, 0.0, 1.0)
    length = float(np.linalg.norm(behind))
    away = behind / length + (0.0, EGO_RISE, 0.0) if length > 1e-9 else np.array([0.0, 1.0, 1e-9])
    return framed(away, box, size, angle_deg=EGO_ANGLE_DEG)


def check(view: str) -> None:
    """Raise `InputError` for a view that is neither a name nor three or six numbers."""
    if view not in VIEWS and _numbers(view) is None:
        raise InputError(
            f"view is {view!r}, but one of {', '.join(VIEWS)}, or x,y,z or x,y,z,x,y,z is needed"
        )


def _numbers(view: str) -> Array | None:
    try:
        numbers = np.array([float(number) for number in view.split(",")])
    except ValueError:
        return None
    is_place = len(numbers) in (3, 6) and bool((np.abs(numbers) <= LARGEST).all())
    return numbers if is_place else None


def _placed(view: str, box: Box) -> Viewpoint:
    numbers = _numbers(view)
    assert numbers is not None
    target = numbers[3:] if len(numbers) == 6 else (box[0] + box[1]) / 2.0
    offset = target - numbers[:3]
    if np.hypot(offset[0], offset[2]) < 1e-9 * max(1.0, float(np.abs(offset).max())):
        # Straight down: up in the image is then -z, as in the top view.
        numbers = (
            numbers + np.array([0.0, 0.0, 1e-6 * max(1.0, abs(offset[1])), 0, 0, 0])[: len(numbers)]
        )
    return Viewpoint(T_world_cam=look_at(numbers[:3], target), angle_deg=CAMERA_ANGLE_DEG)


def framed(
    away: Array, box: Box, size: tuple[int, int], *, is_flat: bool = False,
    angle_deg: float = VIEW_ANGLE_DEG,
) -> Viewpoint:  # fmt: skip
    """The camera in the direction `away` (3,), as close as possible with the whole box visible."""
    low, high = box
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    rotation = look_at(away, np.zeros(3))
    seen = (corners - 0.5) * (high - low) @ rotation[:3, :3]
    shape = np.array([size[0] / size[1], 1.0])
    middle, reach = np.zeros(2), np.abs(seen[:, :2])
    half_height = FLAT_FRAME * float((reach / shape).max())
    tangent = np.tan(np.radians(angle_deg) / 2.0)
    distance = FRAME * float((reach / shape / tangent - seen[:, 2:]).max())
    view = Viewpoint(T_world_cam=rotation, angle_deg=angle_deg)
    if is_flat:
        view, distance = replace(view, half_height=half_height), 2.0 * float(np.ptp(seen[:, 2]) + 1)
    else:
        middle, distance = _centred(seen, distance, shape, tangent)
    placed = rotation.copy()
    placed[:3, 3] = (low + high) / 2.0 + rotation[:3, :3] @ np.array([*middle, -distance])
    return replace(view, T_world_cam=placed)


def _centred(seen: Array, distance: float, shape: Array, tangent: float) -> tuple[Array, float]:
    """Lateral shift and distance that centre the box, near and far end."""
    middle = np.zeros(2)
    for _ in range(8):
        shown = (seen[:, :2] - middle) / (seen[:, 2:] + distance) / (shape * tangent)
        depth = float(np.median(seen[:, 2]) + distance)
        middle = middle + (shown.max(axis=0) + shown.min(axis=0)) / 2.0 * shape * tangent * depth
        shown = (seen[:, :2] - middle) / (seen[:, 2:] + distance) / (shape * tangent)
        nearest = float(-seen[:, 2].min())
        scaled = (distance - nearest) * FRAME * float(np.abs(shown).max()) + nearest
        distance = max(scaled, nearest + 1e-6 * float(np.ptp(seen)))
    return middle, distance
