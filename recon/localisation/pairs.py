"""Registration of pairs: the planar motion between two that show the same."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from recon.geometry import invert, pose, rotation_about_y, wrapped
from recon.localisation.graph import led_by, planar, step_between
from recon.localisation.locate import points_of
from recon.localisation.planar_motion import PlanarMotion, planar_motion, standing
from recon.localisation.registration import Points, Prior, inverse, register
from recon.localisation.surfels import Surfels
from recon.records import PointCloud, StereoPair
from recon.sequences.odometry.motion import MIN_TRACKS, agreeing_tracks
from recon.sequences.odometry.places import Place, see, shared
from recon.sequences.odometry.tracking import Tracks, track
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
"""Systematic error of the motion between common points."""
NEAR_CELLS, NEAR_DEG = 2.5, 60.0
"""Distance and turn up to which corners are tracked from one pair into the other."""
MIN_SHARE = 0.3
"""Minimum share of points on the other pair's surface."""
MAX_OFF = 4.0
"""Maximum distance of an accepted motion from the guess, in standard deviations."""


@dataclass(frozen=True, eq=False)
class Shown:
    """The surface seen by a pair, in the frame of its camera."""

    pair: StereoPair
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
            pair=pair,
            place=see(pair),
            cloud=in_left,
            T_level_left=T_level_left,
            points=points_of(in_left, pair.rig, settings.cell_size),
            map=settings,
        )

    def at(self, place: Array) -> Array:
        """`T_world_left` (4, 4) at x, z and azimuth (3,), with the camera at height 0."""
        return standing(place, self.T_level_left)

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
    step = step_between(*poses)
    found = _by_tracks(first, second, step) or _by_places(first, second, step)
    if found is None:
        return None
    length = FEATURES_CELLS * first.map.cell_size
    least = np.diag([length, length, np.radians(FEATURES_DEG)]) ** 2
    turn = np.eye(3)
    turn[:2, :2] = rotation_about_y(-poses[0][2])[np.ix_([0, 2], [0, 2])]
    there = poses[0] + led_by(poses[:1], found.place[None])[0]
    return there, inverse(turn @ (found.covariance + least) @ turn.T)


def _by_tracks(first: Shown, second: Shown, step: Array) -> PlanarMotion | None:
    """The motion by corners tracked from one pair into the other, where they are near."""
    is_near = np.hypot(*step[:2]) < NEAR_CELLS * first.map.cell_size
    if not is_near or abs(step[2]) > np.radians(NEAR_DEG) or first.pair.rig != second.pair.rig:
        return None
    T_second_first = invert(standing(step, second.T_level_left)) @ first.T_level_left
    return _agreed(track(first.pair, second.pair, T_second_first), first, second, step)


def _by_places(first: Shown, second: Shown, step: Array) -> PlanarMotion | None:
    """The motion by features that look alike."""
    return _agreed(shared(first.place, second.place), first, second, step)


def _agreed(tracks: Tracks, first: Shown, second: Shown, step: Array) -> PlanarMotion | None:
    """The motion on which common points agree."""
    agreeing = agreeing_tracks(tracks, second.pair.rig)
    if agreeing is None or agreeing[1].sum() < MIN_TRACKS:
        return None
    tilts = first.T_level_left, second.T_level_left
    return planar_motion(tracks.select(agreeing[1]), second.pair.rig, tilts, step)


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
