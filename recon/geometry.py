"""Rigid motions and angles.

`T_a_b` maps points given in frame b to frame a: ``p_a = T_a_b @ p_b``; inner names cancel in a
product. The world is right-handed with y up; a camera looks along its z, x right and y down.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError, as_numbers, check_finite, check_shape

Array = NDArray[np.float64]

WORLD_UP: tuple[float, float, float] = (0.0, 1.0, 0.0)

LEVEL_CAMERA: Array = np.diag([1.0, -1.0, -1.0, 1.0])
"""`T_world_camera` at the origin, looking level along -z: the default without a pose."""
LEVEL_CAMERA.setflags(write=False)


def transform(T_a_b: ArrayLike, points_b: ArrayLike) -> Array:
    """Transform points from frame b to frame a.

    Parameters
    ----------
    T_a_b : (4, 4) array_like
    points_b : (N, 3) array_like

    Returns
    -------
    points_a : (N, 3) float64
    """
    T = np.asarray(T_a_b, dtype=np.float64)
    points = np.asarray(points_b, dtype=np.float64)
    check_shape("T_a_b", T, (4, 4))
    check_shape("points_b", points, (None, 3))
    moved: Array = points @ T[:3, :3].T + T[:3, 3]
    return moved


def invert(T_a_b: ArrayLike) -> Array:
    """The inverse `T_b_a` of the rigid motion `T_a_b` (4, 4)."""
    T = np.asarray(T_a_b, dtype=np.float64)
    check_shape("T_a_b", T, (4, 4))
    inverse = np.eye(4)
    inverse[:3, :3] = T[:3, :3].T
    inverse[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return inverse


def pose(rotation: ArrayLike, translation: ArrayLike) -> Array:
    """The (4, 4) rigid motion of a (3, 3) rotation and a (3,) translation."""
    T = np.eye(4)
    T[:3, :3] = rotation
    T[:3, 3] = translation
    return T


def without_drift(T_a_b: ArrayLike) -> Array:
    """The rigid motion (4, 4) nearest to one distorted by the rounding of many products."""
    T = np.asarray(T_a_b, dtype=np.float64)
    u, _, vt = np.linalg.svd(T[:3, :3])
    return pose(u @ vt, T[:3, 3])


def check_rigid(name: str, T: ArrayLike) -> None:
    """Raise `InputError` unless `T` is a (4, 4) rotation and translation, to 1e-6."""
    matrix = as_numbers(name, T)
    check_shape(name, matrix, (4, 4))
    check_finite(name, matrix)
    for _, said in _not_rigid(matrix[None]):
        raise InputError(f"{name} is {said}")


def check_poses(name: str, poses: Array) -> None:
    """Raise `InputError` unless `poses` is (N, 4, 4), each a rotation and translation."""
    check_shape(name, poses, (None, 4, 4))
    check_finite(name, poses)
    for number, said in _not_rigid(poses):
        raise InputError(f"{name}[{number}] is {said}")


def _not_rigid(poses: Array) -> Iterator[tuple[int, str]]:
    """Number and fault of each matrix that is not a rotation and a translation, to 1e-6."""
    rotations = poses[:, :3, :3]
    errors = np.abs(rotations @ rotations.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    volumes = np.linalg.det(rotations)
    is_wrong = (errors > 1e-6) | (volumes < 0) | (poses[:, 3] != (0, 0, 0, 1)).any(axis=1)
    for number in np.flatnonzero(is_wrong).tolist():
        said = f"R R^T is off by {errors[number]:.2g}, det R = {volumes[number]:.3g}"
        need = "a rotation and a translation are needed"
        yield number, f"not a rigid motion ({said}), but {need}"


def look_at(position: ArrayLike, target: ArrayLike, up: ArrayLike = WORLD_UP) -> Array:
    """Pose of a camera at `position` whose z axis goes through `target`.

    Parameters
    ----------
    position, target : (3,) array_like
        In the world.
    up : (3,) array_like
        The direction that points up in the image.

    Returns
    -------
    T_world_cam : (4, 4) float64

    Raises
    ------
    InputError
        If the target is at the position, or straight above or below it.
    """
    eye = np.asarray(position, dtype=np.float64)
    forward = np.asarray(target, dtype=np.float64) - eye
    right = np.cross(forward, np.asarray(up, dtype=np.float64))
    length = np.linalg.norm(right)
    if not length > 1e-12 * max(1.0, float(np.linalg.norm(forward))):
        raise InputError(
            f"target {np.asarray(target).tolist()} seen from {eye.tolist()} gives no "
            "horizontal direction, but one is needed"
        )
    x = right / length
    z = forward / np.linalg.norm(forward)
    return pose(np.column_stack([x, np.cross(z, x), z]), eye)


def rotation_about_y(angle_rad: float) -> Array:
    """(3, 3) rotation about the world's vertical, counter-clockwise seen from above."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def wrapped(angle_rad: ArrayLike) -> Array:
    """Angles wrapped to [-pi, pi]."""
    turns: Array = np.angle(np.exp(1j * np.asarray(angle_rad)))
    return turns


def hue_distance_deg(a_deg: ArrayLike, b_deg: ArrayLike) -> Array:
    """Distance of two hues around the colour circle, 0 to 180 degrees."""
    difference = np.mod(np.asarray(a_deg, float) - np.asarray(b_deg, float), 360.0)
    distance: Array = np.minimum(difference, 360.0 - difference)
    return distance
