"""The referee: measures an exploration against the true world, independently of the agent."""

import itertools
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exploration.explorable import Explorable, KnownWorld
from recon.exploration.floor import Array, Floor, Mask
from recon.exploration.metrics import path_bound
from recon.exploration.oracle import oracle_path
from recon.exploration.scales import Scales
from recon.records import View
from recon.settings import Settings

SAMPLE = 0.2
"""Distance between two samples of a path, in body radii."""


@dataclass(slots=True, kw_only=True, eq=False)
class Referee:
    """Measurements during the walk, which the agent itself never uses."""

    world: KnownWorld
    settings: Settings
    free: Mask = field(init=False)
    """(X, Z) floor cells outside the true footprints."""
    min_clearance: float = np.inf
    """Minimum distance so far between the body's axis and a surface, world units."""

    def __post_init__(self) -> None:
        self.free = self.world.free_ground(self.settings.map.cell_size)

    def check_start(self, start: View) -> None:
        """Raise `InputError` if the body cannot stand at the start."""
        x, y, z = start.position
        clearance = float(self._clearance(start.position[None])[0])
        upright = np.array([[x, share * y, z] for share in (0.1, 0.5, 1.0)])
        if self.world.is_inside(upright).any() or clearance < self.settings.motion.body_radius:
            raise InputError(
                f"exploration.start_position: x {x:g}, z {z:g} is inside or against an "
                "object, but free ground is needed; choose another start"
            )
        self.min_clearance = clearance

    def walk(self, path: Array) -> Array | None:
        """Measure a path (N, 3); returns the first position (2,) of a collision, or None.

        A path with a collision is not recorded.
        """
        places = samples(path, self._step)
        clearance = self._clearance(places)
        collides = clearance < self.settings.motion.body_radius
        if collides.any():
            contact: Array = places[collides.argmax(), [0, 2]]
            return contact
        self.min_clearance = min(self.min_clearance, float(clearance.min()))
        return None

    def coverage(self, floor: Floor) -> float:
        """Known free cells as a share of all free cells; 1 if there are none."""
        known = float((floor.known_free & self.free).sum())
        return known / self.free.sum() if self.free.any() else 1.0

    def metrics(self, start: View) -> dict[str, Any]:
        """The numbers of metrics.json that need ground truth."""
        reach = self.settings.exploration.viewing_distance
        return {
            "path_bound": path_bound(start, self.world.objects, reach),
            "oracle_path": self._oracle_path(start),
            "min_clearance": self.min_clearance,
        }

    def _oracle_path(self, start: View) -> float | None:
        world, cell_size = self.settings.world, self.settings.map.cell_size
        floor = Floor(size_x=world.size_x, size_z=world.size_z, cell_size=cell_size)
        scales = Scales.of(self.settings)
        return oracle_path(start.position[[0, 2]], self.world.objects, self.free, floor, scales)

    @property
    def _step(self) -> float:
        return SAMPLE * self.settings.motion.body_radius

    def _clearance(self, positions: Array) -> Array:
        return self.world.body_clearance(positions[:, [0, 2]], self.settings.motion.body_height)


def referee_of(source: Explorable, settings: Settings) -> Referee | None:
    """The referee of an explored world; None if the truth is not known."""
    return Referee(world=source, settings=settings) if isinstance(source, KnownWorld) else None


def samples(path: Array, step: float) -> Array:
    """Points (M, 3) of a path (N, 3), including its corners, at most `step` apart."""
    points = [path[:1]]
    for a, b in itertools.pairwise(path):
        number = 1 + int(np.ceil(np.linalg.norm(b - a) / step))
        points.append(np.linspace(a, b, number))
    return np.vstack(points)
