"""What the agent remembers: its map, the floor, and the things it has met."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import binary_closing

from recon.exploration.floor import NEIGHBOURS, Array, Floor, Mask
from recon.exploration.sight import Sight, Sighting, look, sightings, sigma_of, without_noise
from recon.exploration.things import Thing, Visits, columns, find_things
from recon.recognition import recognise
from recon.records import FoundObject, PointCloud, StereoPair, View
from recon.settings import Settings
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import occupied

SURE_SIGMA = 1.0
"""A point has seen its thing well when its depth is known to one cell."""
MARGIN = 3.0
"""World units round a mapped thing within which a new point is one more of its own."""
NUM_VIEWS = 3
"""A thing is named first when so many views have seen it well ..."""
GROWTH = 1.25
"""... and again when it has grown by this factor since."""


@dataclass(slots=True, kw_only=True, eq=False)
class Memory:
    """The agent's state; `remember` is all that changes it."""

    settings: Settings
    voxel_map: VoxelMap
    floor: Floor = field(init=False)
    visits: Visits = field(default_factory=Visits)
    things: tuple[Thing, ...] = ()
    sightings: tuple[Sighting, ...] = ()
    """Things seen that are not in the map."""
    timeline: list[tuple[int, tuple[FoundObject, ...]]] = field(default_factory=list)
    """Number of pairs taken, and the objects named by then, whenever these changed."""

    def __post_init__(self) -> None:
        world = self.settings.world
        self.floor = Floor(size_x=world.size_x, size_z=world.size_z)

    @property
    def objects(self) -> tuple[FoundObject, ...]:
        """Things named so far."""
        return tuple(thing.found for thing in self.things if thing.found is not None)

    @property
    def ground(self) -> float:
        """Height above which something stands on the floor."""
        recognition = self.settings.recognition
        return (recognition.ground or 0.0) + recognition.ground_clearance

    def remember(self, view: View, pair: StereoPair, cloud: PointCloud) -> None:
        """Take in one more pair, whose sure points are in the map already."""
        height = cloud.points[:, 1]
        standing = cloud.select((height >= self.ground) & (height <= self.settings.world.height))
        place = view.position[[0, 2]]
        standing = without_noise(standing, place)
        sure = standing.select(sigma_of(standing) <= SURE_SIGMA)
        self.visits.add(place, sure, self.floor)
        voxels = occupied(self.voxel_map, self.settings.map)
        voxels = voxels.select(voxels.centres[:, 1] >= self.ground)
        self.floor.occupied = binary_closing(self.floor.mask(columns(voxels)), NEIGHBOURS)
        min_voxels = self.settings.recognition.min_voxels
        before = [thing for thing in self.things if thing.found is not None]
        things = find_things(voxels, self.floor, self.visits, min_voxels)
        self.things = tuple(_with_name(thing, before) for thing in things)
        sight = look(view, pair, standing, self.settings.exploration.sight_range)
        self.floor.see(place, sight.azimuths_rad, sight.limits)
        self._hear(sight, standing)

    def name_things(self) -> None:
        """Recognise the things that were seen often enough, and have changed since last time."""
        self.things = tuple(
            self._named(thing) if _is_due(thing) else thing for thing in self.things
        )
        if not self.timeline or self.objects != self.timeline[-1][1]:
            self.timeline.append((len(self.visits.places), self.objects))

    def _named(self, thing: Thing) -> Thing:
        objects = recognise(thing.voxels, self.settings.recognition).objects
        largest = max(objects, key=lambda found: found.num_voxels, default=None)
        return replace(thing, found=largest, num_named=len(thing.voxels))

    def _hear(self, sight: Sight, standing: PointCloud) -> None:
        """Bring the things that are not in the map up to date."""
        points_xz = standing.points[:, [0, 2]]
        new = standing.select(~self._is_mapped(points_xz, sigma_of(standing)))
        for sighting in sightings(new, sight.place):
            self._note(sighting)
        self.sightings = tuple(s for s in self.sightings if not self._is_settled(s))

    def _is_settled(self, sighting: Sighting) -> bool:
        """Whether a sighting is in the map by now, or was noise.

        It was noise if somebody who stood nearer saw the ground there free.
        """
        seen_from = self.floor.seen_from[self.floor.disc(sighting.centre, sighting.radius)]
        if not len(seen_from) or np.median(seen_from) < sighting.distance - sighting.radius:
            return True
        return bool(self._is_mapped(sighting.centre[None], sighting.sigma)[0])

    def _is_mapped(self, points_xz: Array, sigma: Array | float) -> Mask:
        """(N,) which points belong, within their errors, to a thing of the map."""
        mapped = np.zeros(len(points_xz), dtype=bool)
        for thing in self.things:
            mapped |= np.hypot(*(points_xz - thing.centre).T) <= thing.radius + MARGIN + sigma
        return mapped

    def _note(self, new: Sighting) -> None:
        """Keep a sighting; of two that may be of one thing, the surer one."""
        same = [old for old in self.sightings if _may_be_one(old, new)]
        others = tuple(old for old in self.sightings if not _may_be_one(old, new))
        self.sightings = (*others, min([*same, new], key=lambda sighting: sighting.sigma))


def _may_be_one(a: Sighting, b: Sighting) -> bool:
    apart = float(np.hypot(*(a.centre - b.centre)))
    return apart <= max(MARGIN, a.radius, b.radius, 2.0 * (a.sigma + b.sigma))


def _is_due(thing: Thing) -> bool:
    has_grown = len(thing.voxels) > GROWTH * thing.num_named
    return has_grown and len(thing.bearings_rad) >= NUM_VIEWS


def _with_name(thing: Thing, named: list[Thing]) -> Thing:
    """A thing with the name that it had before, if it had one."""
    inside = [other for other in named if thing.holds(other.centre[None])[0]]
    if not inside:
        return thing
    same = min(inside, key=lambda other: float(np.hypot(*(other.centre - thing.centre))))
    return replace(thing, found=same.found, num_named=same.num_named)
