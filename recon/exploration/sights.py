"""Sights: pairs with the poses at which the agent believes they were taken."""

from dataclasses import dataclass, replace

import numpy as np

from recon.exploration.floor import Array
from recon.geometry import invert, pose, rotation_about_y, transform, without_drift, wrapped
from recon.localisation.graph import planar
from recon.mapping.pair import PairResult
from recon.records import PointCloud, StereoPair, View


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sight:
    """One pair with the pose at which the agent believes it was taken."""

    view: View
    pair: StereoPair
    result: PairResult | None = None
    """Its matches and points, in the believed world frame; None if not yet computed."""

    @property
    def cloud(self) -> PointCloud:
        """Its reliable points, in the believed world frame."""
        assert self.result is not None
        return self.result.cloud

    @property
    def planar(self) -> Array:
        """(3,) x, z of the left camera, and the azimuth of straight ahead."""
        assert self.pair.T_world_left is not None
        return planar(self.pair.T_world_left)

    def moved(self, T_new_old: Array) -> "Sight":
        """The same sight at a corrected pose."""
        places = transform(T_new_old, np.array([self.view.position, self.view.target]))
        assert self.pair.T_world_left is not None
        return Sight(
            view=replace(self.view, position=places[0], target=places[1]),
            pair=replace(self.pair, T_world_left=without_drift(T_new_old @ self.pair.T_world_left)),
            result=self.result and self.result.transformed(T_new_old),
        )

    def motion(self, old: Array, new: Array) -> Array:
        """The transform (4, 4) that moves it from one planar pose (3,) to another."""
        assert self.pair.T_world_left is not None
        eye = self.pair.T_world_left[:3, 3]
        there = np.array([new[0], eye[1], new[1]])
        turn = rotation_about_y(-float(wrapped(new[2] - old[2])))
        return pose(turn, there) @ invert(pose(np.eye(3), eye))
