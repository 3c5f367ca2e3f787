"""Registration of pairs: the planar motion between two that show the same."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from recon.geometry import invert, pose, rotation_about_y, transform, wrapped
from recon.localisation.graph import planar
from recon.localisation.links import led_by
from recon.localisation.locate import points_of
from recon.localisation.planar_motion import planar_motion, standing
from recon.localisation.registration import Points, Prior, inverse, register
from recon.localisation.surfels import Surfels
from recon.records import PointCloud, StereoPair
from recon.sequences.odometry.places import Place, see, shared
from recon.sequences.odometry.tracking import Tracks, likeness, track
from recon.settings import MapSettings
from recon.voxelmap import VoxelMap

Array = NDArray[np.float64]

PLANAR = [3, 5, 1]
"""x, z and the rotation about the vertical, among the six parameters of a `PoseEstimate`."""
SIGN = np.diag([1.0, 1.0, -1.0])
"""Rotations about the vertical reduce azimuths."""
LEVEL_SIGMA = 1e-4
"""Standard deviation of height and tilt, radians and world units: a robot's cameras stay level."""
SHAPE_CELLS, SHAPE_DEG = 0.05, 0.1
"""Systematic difference between the surfaces of two pairs."""
FEATURES_CELLS, FEATURES_DEG = 0.02, 0.05
"""Systematic error of the motion between common points."""
NEAR_CELLS, NEAR_DEG = 2.5, 60.0
"""Distance and turn up to which corners are tracked from one pair into the other."""
MIN_LIKENESS = 0.6
"""Minimum correlation of the windows of a tracked corner: 0.2 at most where both images show only
noise, over 0.8 elsewhere. What is tracked through noise stays where it was guessed."""
SAME_SIDE_DEG = 50.0
"""Angle between two views of a surface up to which its features look alike."""
MIN_POINTS, MIN_SURFELS = 30, 10
"""Fewer points of a pair, or pieces of the surface of another, determine no motion."""
MIN_SHARE = 0.3
"""Minimum share of points on the other pair's surface."""
MIN_GAIN, NO_GAIN = 0.2, 1e-6
"""Information relative to what was known that a direction must gain to count, and what it has
otherwise."""
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

    @cached_property
    def middle(self) -> Array | None:
        """Middle (2,) of what is seen, ahead and aside; None if nothing is."""
        if not len(self.cloud):
            return None
        x, _, z = transform(self.T_level_left, np.median(self.cloud.points, axis=0)[None])[0]
        return np.array([x, z])

    @cached_property
    def surfels(self) -> Surfels:
        """Surfels of the points that a map would take, in the frame of the camera."""
        voxel_map, cloud = VoxelMap(self.map.cell_size), self.cloud
        if self.map.max_sigma is not None and cloud.sigma is not None:
            cloud = cloud.select(cloud.sigma <= self.map.max_sigma * self.map.cell_size)
        voxel_map.insert(cloud)
        return Surfels.of(voxel_map.occupied(3))


def linked(first: Shown, second: Shown, step: Array, spread: Array) -> tuple[Array, Array] | None:
    """The step (3,) from one pair to another, and its information (3, 3).

    Uses features if the pairs show the same side, otherwise the surfaces that both see. None if
    neither works.

    Parameters
    ----------
    step, spread : (3,), (3, 3) arrays
        Forwards, sideways and around, as currently known, and its covariance.
    """
    for measure in (_by_features, _by_shape):
        found = measure(first, second, step, spread)
        if found is not None and _is_likely(found, step, spread):
            return found
    return None


def _is_likely(found: tuple[Array, Array], step: Array, spread: Array) -> bool:
    off = found[0] - step
    off[2] = wrapped(off[2])
    return bool(off @ inverse(spread + inverse(found[1])) @ off < MAX_OFF**2)


def _by_features(
    first: Shown, second: Shown, step: Array, spread: Array
) -> tuple[Array, Array] | None:
    """The step on which most common features agree; None if the pairs see other sides."""
    if _turn_of_sight(second, step) > np.radians(SAME_SIDE_DEG):
        return None
    tilts, rig = (first.T_level_left, second.T_level_left), second.pair.rig
    found = [
        planar_motion(tracks, rig, tilts, step, spread) for tracks in _tracks(first, second, step)
    ]
    best = max((one for one in found if one), key=lambda one: one.num_agreeing, default=None)
    if best is None:
        return None
    least = _least(first, FEATURES_CELLS, FEATURES_DEG)
    place, information = told(best.place, best.information, (step, spread), least)
    return place, without(information, best.feigned)


def without(information: Array, feigned: Array) -> Array:
    """The information (3, 3) that remains without what is feigned; next to none if all may be."""
    root = np.linalg.cholesky(information)
    back = np.linalg.inv(root)
    share, axes = np.linalg.eigh(back @ feigned @ back.T)
    along = root @ axes
    left: Array = (along * np.maximum(1.0 - share, NO_GAIN)) @ along.T
    return left


def _turn_of_sight(second: Shown, step: Array) -> float:
    """Angle between the directions from which two pairs see what the second one shows."""
    if second.middle is None:
        return np.inf
    ((dx, dz, _),) = led_by(step[None], np.append(second.middle, 0.0)[None])
    x, z = step[0] + dx, step[1] + dz
    return abs(float(np.arctan2(x * dz - z * dx, x * dx + z * dz)))


def _tracks(first: Shown, second: Shown, step: Array) -> Iterator[Tracks]:
    """Features that look alike, and corners tracked from one pair into the other if near."""
    yield shared(first.place, second.place)
    is_near = np.hypot(*step[:2]) < NEAR_CELLS * first.map.cell_size
    if is_near and abs(step[2]) < np.radians(NEAR_DEG) and first.pair.rig == second.pair.rig:
        T_second_first = invert(standing(step, second.T_level_left)) @ first.T_level_left
        tracks = track(first.pair, second.pair, T_second_first)
        yield tracks.select(likeness(first.pair, second.pair, tracks) > MIN_LIKENESS)


def _by_shape(
    first: Shown, second: Shown, step: Array, spread: Array
) -> tuple[Array, Array] | None:
    """The step at which the points of the second pair are on the surface of the first."""
    if len(second.points) < MIN_POINTS or len(first.surfels) < MIN_SURFELS:
        return None
    information = np.diag(np.full(6, LEVEL_SIGMA**-2.0))
    information[np.ix_(PLANAR, PLANAR)] = inverse(SIGN @ spread @ SIGN)
    start = Prior(T_world_left=standing(step, second.T_level_left), information=information)
    # In the levelled frame of the first camera, in which the motion is planar.
    found = register(second.points, first.surfels.moved(first.T_level_left), start)
    if found is None or found.contacts.num_points < MIN_SHARE * len(second.points):
        return None
    known = found.information / max(1.0, found.contacts.spread**2)
    level = SIGN @ known[np.ix_(PLANAR, PLANAR)] @ SIGN
    least = _least(first, SHAPE_CELLS, SHAPE_DEG)
    return told(planar(found.T_world_left), level, (step, spread), least)


def _least(shown: Shown, cells: float, degrees: float) -> Array:
    """Covariance (3, 3) of systematic errors."""
    length = cells * shown.map.cell_size
    return np.diag([length, length, np.radians(degrees)]) ** 2


def told(
    place: Array, information: Array, known: tuple[Array, Array], least: Array
) -> tuple[Array, Array]:
    """The step by its points alone: the estimate without what was known before.

    Directions of which they tell next to nothing are left where they were known.

    Parameters
    ----------
    place, information : (3,), (3, 3) arrays
        The estimate, and the information of the points.
    known : ((3,) array, (3, 3) array)
        Step and covariance that the estimate was made with.
    least : (3, 3) array
        Covariance of systematic errors.
    """
    step, spread = known
    root = np.linalg.cholesky(spread)
    gain, axes = np.linalg.eigh(root.T @ information @ root)
    tells = gain > MIN_GAIN
    off = place - step
    off[2] = wrapped(off[2])
    change = axes.T @ np.linalg.solve(root, off)
    change[tells] *= (1.0 + gain[tells]) / gain[tells]
    back = np.linalg.inv(root).T @ axes
    alone = (back * np.where(tells, gain, NO_GAIN)) @ back.T
    return step + root @ axes @ change, inverse(inverse(alone) + least)
