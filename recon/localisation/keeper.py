"""The keeper of an atlas: collects the places of pairs and limits their number."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.geometry import invert
from recon.localisation.atlas import Atlas
from recon.records import StereoPair, Trajectory
from recon.sequences.odometry.places import Place, see

Array = NDArray[np.float64]

MAX_PLACES = 2000
"""Maximum number before thinning: with 250 points each they need over 70 MB."""
SAME_TURN_DEG = 3.0
SAME_SHARE = 0.03
"""Share of the median depth of a place within which a pair shows nothing new."""
MIN_POINTS = 12


class PlaceKeeper:
    """Keeps the places of pairs that show something new."""

    def __init__(self) -> None:
        self._places: dict[int, Place] = {}
        self._poses: dict[int, Array] = {}
        self._thinning = 1

    def add(self, pair: StereoPair, number: int) -> None:
        """Add the next pair; a pair without a pose is skipped."""
        T_world_left = pair.T_world_left
        if T_world_left is None or number % self._thinning or self._is_known(T_world_left):
            return
        place = see(pair)
        if len(place) < MIN_POINTS:
            return
        self._places[number], self._poses[number] = place, T_world_left
        if len(self._places) > MAX_PLACES:
            self._thin()

    def atlas(self, trajectory: Trajectory) -> Atlas:
        """The places with the poses of their pairs in a trajectory."""
        return atlas_of(self._places, trajectory)

    def _is_known(self, T_world_left: Array) -> bool:
        """True if the last place shows the same."""
        if not self._places:
            return False
        number = next(reversed(self._places))
        place, off = self._places[number], invert(self._poses[number]) @ T_world_left
        turn = np.degrees(Rotation.from_matrix(off[:3, :3]).magnitude())
        return bool(np.linalg.norm(off[:3, 3]) < SAME_SHARE * place.depth and turn < SAME_TURN_DEG)

    def _thin(self) -> None:
        """Keep every second of the remaining place numbers."""
        self._thinning *= 2
        self._places = {n: place for n, place in self._places.items() if n % self._thinning == 0}


def atlas_of(places: Mapping[int, Place], trajectory: Trajectory) -> Atlas:
    """The atlas of numbered places."""
    numbers = list(places)
    poses = trajectory.T_world_left[numbers] if numbers else np.zeros((0, 4, 4))
    return Atlas(places=list(places.values()), numbers=numbers, T_world_left=poses)
