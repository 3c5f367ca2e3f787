"""Channels of matched points, by the names of the channel menu (thesis figure 23)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.figures.partition import owners
from recon.records import Features, FoundObject, Matches, StereoPair

Array = NDArray[np.float64]

PLAIN = "none"
CHANNELS = (
    PLAIN, "x", "y", "z", "disparity", "depth", "sigma", "orientation", "score", "label",
)  # fmt: skip
UNITS = {
    "disparity": "px", "orientation": "deg", "x": "units", "y": "units", "z": "units",
    "depth": "units", "sigma": "units",
}  # fmt: skip
LABEL = "label"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Points:
    """Matched points of a pair."""

    left_px: Array
    """(M, 2)"""
    right_px: Array
    """(M, 2) the matched points."""
    channels: Mapping[str, Array]
    """(M,) values by name."""
    names: Mapping[int, str]
    """Labels of objects by id; the channel `label` contains the ids."""

    def __len__(self) -> int:
        return len(self.left_px)

    def nearest(self, side: str, at: tuple[float, float], reach_px: float) -> int | None:
        """The point nearest to a pixel of one side; None if none is within reach."""
        points = self.left_px if side == "left" else self.right_px
        if not len(points):
            return None
        away = np.hypot(*(points - at).T)
        nearest = int(away.argmin())
        return nearest if away[nearest] <= reach_px else None

    def describe(self, number: int) -> str:
        """All channels of one point, one line each."""
        lines = [f"point {number}"]
        (u, v), (right_u, right_v) = self.left_px[number], self.right_px[number]
        lines += [f"left: {u:.2f}, {v:.2f} px", f"right: {right_u:.2f}, {right_v:.2f} px"]
        for name, values in self.channels.items():
            if name == LABEL:
                lines.append(f"{name}: {self.names.get(int(values[number]), 'none')}")
            else:
                lines.append(f"{name}: {values[number]:.5g} {UNITS.get(name, '')}".rstrip())
        return "\n".join(lines)


def points_of(
    pair: StereoPair,
    matches: Matches,
    left: Features,
    objects: tuple[FoundObject, ...],
    cell_size: float,
) -> Points:
    """The matched points of a pair with all their channels; cells have a size in world units."""
    points = pair.rig.triangulate(matches.points_px, matches.disparity_px)
    depth = points[:, 2]
    if pair.T_world_left is not None:
        points = points @ pair.T_world_left[:3, :3].T + pair.T_world_left[:3, 3]
    shift = np.column_stack([matches.disparity_px, np.zeros(len(matches))])
    return Points(
        left_px=matches.points_px,
        right_px=matches.points_px - shift,
        channels={
            "x": points[:, 0],
            "y": points[:, 1],
            "z": points[:, 2],
            "disparity": matches.disparity_px,
            "depth": depth,
            "sigma": pair.rig.depth_sigma(depth, matches.sigma_px),
            "orientation": np.degrees(left.orientation_rad[matches.index_left]).astype(np.float64),
            "score": matches.score,
            LABEL: owners(points, objects, cell_size),
        },
        names={found.id: f"{found.label} {found.id}" for found in objects},
    )
