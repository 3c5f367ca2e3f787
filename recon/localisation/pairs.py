"""Registration of pairs: the planar motion between two that show the same."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from recon.geometry import invert, pose, rotation_about_y, wrapped
from recon.localisation.graph import planar
from recon.localisation.locate import points_of
from recon.localisation.registration import Points, Prior, inverse, register
from recon.localisation.surfels import Surfels
from recon.records import PointCloud, StereoPair
from recon.sequences.odometry.motion import linearise
from recon.sequences.odometry.places import Place, meet, see
from recon.settings import MapSettings
from recon.voxelmap import VoxelMap

Array = NDArray[np.float64]

PLANAR = [3, 5, 1]
"""x, z and the rotation about the vertical, among the six parameters of a `PoseEstimate`."""
LEVEL_SIGMA = 1e-4
"""Standard deviation of height and tilt, radians and world units: a robot's cameras stay level."""
SHAPE_CELLS, SHAPE_DEG = 0.05, 0.1
"""Systematic difference between the surfaces of two pairs."""
FEATURES_CELLS, FEATURES_DEG = 0.02, 0.05
COMMON_PX = 0.03
"""Difference between the common errors of all disparities of two pairs: far from everything, their
points agree on a wrong motion."""
MIN_SHARE = 0.3
"""Minimum share of points on the other pair's surface."""
MAX_OFF = 4.0
"""Maximum distance of an accepted motion from the guess, in standard deviations."""


@dataclass(frozen=True, eq=False)
class Shown:
    """The surface seen by a pair, in the frame of its camera."""

    place: Place
    cloud: PointCloud
    """Left frame, axes of the world: turned level, x ahead is not."""
    T_level_left: Array
    """(4, 4) tilt of the camera, which is at the origin with azimuth 0."""
    points: Points
    map: MapSettings

    @classmethod
    def of(cls, pair: StereoPair, cloud: PointCloud, settings: MapSettings) -> "Shown":
        """The surface of a pair whose cloud is in the world frame."""
        assert pair.T_world_left is not None
        azimuth = float(planar(pair.T_world_left)[2])
        T_level_left = pose(rotation_about_y(azimuth) @ pair.T_world_left[:3, :3], np.zeros(3))
        in_left = cloud.transformed(invert(pair.T_world_left))
        return cls(
            place=see(pair),
            cloud=in_left,
            T_level_left=T_level_left,
            points=points_of(in_left, pair.rig, settings.cell_size),
            map=settings,
        )

    def at(self, place: Array) -> Array:
        """`T_world_left` (4, 4) at x, z and azimuth (3,), with the camera at height 0."""
        x, z, azimuth = place
        return pose(rotation_about_y(-azimuth), [x, 0.0, z]) @ self.T_level_left

    @cached_property
    def surfels(self) -> Surfels:
        """Surfels of the points that a map would take, in the frame of the camera."""
        voxel_map, cloud = VoxelMap(self.map.cell_size), self.cloud
        if self.map.max_sigma is not None and cloud.sigma is not None:
            cloud = cloud.select(cloud.sigma <= self.map.max_sigma * self.map.cell_size)
        voxel_map.insert(cloud)
        return Surfels.of(voxel_map.occupied(3))


def linked(first: Shown, second: Shown, poses: Array, spread: Array) -> tuple[Array, Array] | None:
    """The poses (2, 3) of two pairs and the information (3, 3) of the motion between them.

    Uses features if the pairs show the same side, otherwise the surfaces that both see. None if
    neither works.

    Parameters
    ----------
    poses : (2, 3) array
        x, z and azimuth, as currently known.
    spread : (3, 3) array
        Covariance of the second pose relative to the first.
    """
    for measure in (_by_features, _by_shape):
        found = measure(first, second, poses, spread)
        if found is not None and _is_likely(found, poses, spread):
            return np.array([poses[0], found[0]]), found[1]
    return None


def _is_likely(found: tuple[Array, Array], poses: Array, spread: Array) -> bool:
    off = found[0] - poses[1]
    off[2] = wrapped(off[2])
    whole = spread + inverse(found[1])
    return bool(off @ inverse(whole) @ off < MAX_OFF**2)


def _by_features(
    first: Shown, second: Shown, poses: Array, spread: Array
) -> tuple[Array, Array] | None:
    del spread
    met = meet(first.place, second.place)
    if met is None:
        return None
    T_world_left = first.at(poses[0]) @ invert(met.T_second_first)
    at = linearise(met.T_second_first, met.tracks, second.place.rig)
    turn = np.kron(np.eye(2), T_world_left[:3, :3])
    information = turn @ at.normal_equations()[0] @ turn.T / at.spread**2
    rig = second.place.rig
    depth = float(np.median(rig.depth(met.tracks.second.disparity_px)))
    shift = float(rig.depth_sigma(depth, COMMON_PX))
    cells = FEATURES_CELLS + shift / first.map.cell_size
    # A wrong distance turns the motion about what is seen as well.
    return planar(T_world_left), _known(
        information, first, cells, FEATURES_DEG + float(np.degrees(shift / depth))
    )


def _by_shape(
    first: Shown, second: Shown, poses: Array, spread: Array
) -> tuple[Array, Array] | None:
    if len(second.points) < 30 or len(first.surfels) < 10:
        return None
    T_first_second = invert(first.at(poses[0])) @ second.at(poses[1])
    # In the levelled frame of the first camera, in which the motion is planar.
    level = first.T_level_left
    start = level @ T_first_second
    information = np.diag(np.full(6, LEVEL_SIGMA**-2.0))
    turn = rotation_about_y(poses[0][2])
    sign = np.diag([1.0, 1.0, -1.0])
    about = np.eye(3)
    about[:2, :2] = turn[np.ix_([0, 2], [0, 2])]
    local = inverse(sign @ about @ spread @ about.T @ sign)
    information[np.ix_(PLANAR, PLANAR)] = local
    surfels = first.surfels.moved(level)
    found = register(second.points, surfels, Prior(T_world_left=start, information=information))
    if found is None or found.contacts.num_points < MIN_SHARE * len(second.points):
        return None
    T_world_left = first.at(poses[0]) @ invert(level) @ found.T_world_left
    scale = max(1.0, found.contacts.spread**2)
    world = np.kron(np.eye(2), first.at(poses[0])[:3, :3] @ level[:3, :3].T)
    whole = world @ found.information @ world.T / scale
    return planar(T_world_left), _known(whole, first, SHAPE_CELLS, SHAPE_DEG)


def _known(information: Array, shown: Shown, cells: float, degrees: float) -> Array:
    """Information (3, 3) of x, z, azimuth for known height and tilt, with a minimum covariance."""
    sign = np.diag([1.0, 1.0, -1.0])
    planar = sign @ information[np.ix_(PLANAR, PLANAR)] @ sign
    length = cells * shown.map.cell_size
    least = np.array([length, length, np.radians(degrees)])
    return inverse(inverse(planar + 1e-6 * np.eye(3)) + np.diag(least**2))
