"""What a controller is told, and the way it may answer."""

from dataclasses import dataclass, field

import numpy as np

from recon.exploration.floor import Array, Floor
from recon.exploration.sight import Sighting
from recon.exploration.things import Thing
from recon.records import FoundObject, StereoPair, View
from recon.settings import Settings
from recon.voxelmap import VoxelMap
from recon.world.world import World


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class State:
    """Everything the agent knows after a pair."""

    num_pairs: int
    view: View
    """Where the agent stands, and what it looks at."""
    pair: StereoPair
    """The last pair taken."""
    voxel_map: VoxelMap
    floor: Floor
    """Known, occupied and unknown ground."""
    things: tuple[Thing, ...]
    """Things in the map."""
    sightings: tuple[Sighting, ...]
    """Things seen, but too far off to be in the map."""
    objects: tuple[FoundObject, ...]
    """What has been recognised so far."""
    simulator: World
    """The world itself, for whatever a plug-in wants of it; what comes with recon only looks."""
    settings: Settings

    @property
    def place(self) -> Array:
        """(2,) x, z of the agent."""
        place: Array = self.view.position[[0, 2]]
        return place


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Walk(View):
    """A view, and the way to it."""

    via: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(N, 3) corners of the way between here and the view, world."""
