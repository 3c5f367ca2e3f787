"""The state that a controller receives, and the walk that it may return."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from recon.exploration.explorable import KnownWorld
from recon.exploration.floor import Array, Floor
from recon.exploration.obstacles import Obstacle
from recon.exploration.scales import Scales
from recon.exploration.scan import Detection
from recon.records import FoundObject, StereoPair, View
from recon.settings import Settings
from recon.voxelmap import VoxelMap


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class State:
    """Everything the agent knows after a pair."""

    num_pairs: int
    view: View
    """The position of the agent and its target."""
    pair: StereoPair
    """The last pair taken."""
    voxel_map: VoxelMap
    floor: Floor
    """Known, occupied and unknown ground."""
    obstacles: tuple[Obstacle, ...]
    """Obstacles of the map."""
    detections: tuple[Detection, ...]
    """Obstacles seen, but too far away to be in the map."""
    refuted: Sequence[Detection]
    """Those that are not where they seemed to be."""
    sure_range: float
    """Distance up to which a view shows an obstacle well enough for the map, world units."""
    objects: tuple[FoundObject, ...]
    """Objects recognised so far."""
    simulator: KnownWorld | None
    """The world itself if it is simulated, otherwise None; recon's own controllers do not use
    it."""
    settings: Settings

    @property
    def place(self) -> Array:
        """(2,) x, z of the agent."""
        place: Array = self.view.position[[0, 2]]
        return place

    @property
    def scales(self) -> Scales:
        """Lengths for decisions."""
        return Scales.of(self.settings)

    def within(self, reach: float) -> "State":
        """The part of the state within reach of the agent along x and z."""
        floor = self.floor.window(self.place, reach)
        shift = floor.cells(self.floor.corner + 0.5 * floor.cell_size)
        inside = [_inside(one, floor, shift) for one in self.obstacles]
        return replace(
            self,
            floor=floor,
            obstacles=tuple(one for one in inside if len(one.cells)),
            detections=tuple(d for d in self.detections if floor.holds(floor.cells(d.centre))),
        )


def _inside(obstacle: Obstacle, floor: Floor, shift: NDArray[np.intp]) -> Obstacle:
    """An obstacle with its cells on a part of the floor, shifted (2,) to that part."""
    if not shift.any() and floor.holds(floor.cells(obstacle.centre + obstacle.radius)):
        return obstacle
    cells, covered = obstacle.cells + shift, obstacle.covered + shift
    return replace(obstacle, cells=cells[floor.holds(cells)], covered=covered[floor.holds(covered)])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Walk(View):
    """A view and the path to it."""

    via: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(N, 3) corners of the path between the current position and the view, world."""
