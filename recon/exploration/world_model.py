"""The agent's model of the world: the map, the floor, the obstacles and the detections."""

import itertools
import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import binary_closing
from scipy.spatial.distance import cdist

from recon.exploration.columns import Columns
from recon.exploration.floor import NEIGHBOURS, Array, Floor, Mask
from recon.exploration.obstacles import Observations, Obstacle, UpperEdge, find_obstacles, patches
from recon.exploration.scales import Scales
from recon.exploration.scan import Detection, Scan, detections, polar, scan, sigma_of, without_noise
from recon.exploration.sides import OPEN_SURE_RAD, is_known, widest_gap
from recon.recognition.recognition import recognise
from recon.records import FoundObject, PointCloud, StereoPair, View
from recon.settings import Settings
from recon.voxelmap import VoxelMap

SURE_SIGMA = 1.0
"""A point is reliable if its depth is known to one cell."""
NEARLY_ALL = 0.9
MIN_CELLS = 3
"""Fewer connected cells of the map are noise."""
NUM_VIEWS = 3
"""An obstacle is first named when this number of views have seen it well ..."""
GROWTH, OPEN_GROWTH, KNOWN_GROWTH = 1.25, 2.0, 1.1
"""... and again when it has grown by this factor; if its label is sure, by the second one while it
is not yet seen from all around, and by the third one after that: the name must be that of all its
cells. One that resembles a kind is named again after every view, and one without a sure label that
is seen from all around as well: it may resemble one now."""


@dataclass(slots=True, kw_only=True, eq=False)
class WorldModel:
    """The agent's state, changed only by `update`."""

    settings: Settings
    voxel_map: VoxelMap
    floor: Floor = field(init=False)
    columns: Columns = field(init=False)
    scales: Scales = field(init=False)
    observations: Observations = field(default_factory=Observations)
    obstacles: tuple[Obstacle, ...] = ()
    detections: tuple[Detection, ...] = ()
    """Obstacles seen that are not in the map."""
    refuted: list[Detection] = field(default_factory=list)
    """Those that are not where they seemed to be: closer views saw the ground as free."""
    growth: list[float] = field(default_factory=list)
    """For each pair with points, the growth of sigma with the square of the distance."""
    timeline: list[tuple[int, tuple[FoundObject, ...]]] = field(default_factory=list)
    """Number of pairs and the objects named so far, whenever these changed."""

    def __post_init__(self) -> None:
        world, cell_size = self.settings.world, self.settings.map.cell_size
        self.floor = Floor(size_x=world.size_x, size_z=world.size_z, cell_size=cell_size)
        self.columns = Columns(
            voxel_map=self.voxel_map,
            settings=self.settings.map,
            floor=self.floor,
            ground=self.ground,
        )
        self.scales = Scales.of(self.settings)

    @property
    def objects(self) -> tuple[FoundObject, ...]:
        """Obstacles named so far."""
        return tuple(one.found for one in self.obstacles if one.found is not None)

    @property
    def ground(self) -> float:
        """Height above which something stands on the floor."""
        recognition = self.settings.recognition
        clearance = recognition.clearance(self.settings.map.cell_size)
        return (recognition.ground or 0.0) + clearance

    @property
    def sure_range(self) -> float:
        """Distance up to which nearly all points of a view are reliable, world units."""
        reach = self.scales.viewing_distance
        if not self.growth or np.median(self.growth) == 0.0:
            return reach
        return min(reach, math.sqrt(SURE_SIGMA * self.scales.cell / np.median(self.growth)))

    def standing(self, place: Array, cloud: PointCloud) -> PointCloud:
        """The points (world) of objects on the floor, seen from a position (2,), without noise."""
        return without_noise(self._above(cloud), place, self.scales)

    def _above(self, cloud: PointCloud) -> PointCloud:
        """The points (world) above the ground, and not above the world."""
        height = cloud.points[:, 1]
        return cloud.select((height >= self.ground) & (height <= self.settings.world.height))

    def update(self, view: View, pair: StereoPair, cloud: PointCloud) -> None:
        """Add another pair, whose reliable points are already in the map."""
        place = view.position[[0, 2]]
        standing = self.standing(place, cloud)
        sure = standing.select(sigma_of(standing) <= SURE_SIGMA * self.scales.cell)
        self.observations.add(place, sure, self.floor, UpperEdge.of(pair))
        if len(standing):
            _, distance = polar(standing.points[:, [0, 2]], place)
            growth = np.quantile(sigma_of(standing) / distance**2, NEARLY_ALL)
            self.growth.append(float(growth))
        self._find_obstacles(cloud)
        reach = self.settings.exploration.sight_range
        ground = (self.settings.recognition.ground or 0.0, self.settings.eyes.far)
        seen = scan(view, pair, standing, reach, ground, self.floor)
        self.floor.see(place, seen.azimuths_rad, seen.limits)
        self.floor.bar(place, seen.azimuths_rad, seen.feet)
        self.floor.hit_at(place, sure.points[:, [0, 2]])
        self._detect(seen, self._above(cloud))

    def name_obstacles(self) -> None:
        """Recognise the obstacles that were seen often enough and have changed since."""
        self.obstacles = tuple(self._named(one) if _is_due(one) else one for one in self.obstacles)
        if not self.timeline or self.objects != self.timeline[-1][1]:
            self.timeline.append((len(self.observations.places), self.objects))

    def remember(self, before: "WorldModel") -> None:
        """Take over the names and the touched cells of a model whose map was corrected."""
        named = [one for one in before.obstacles if one.found is not None]
        self.obstacles = with_names(self.obstacles, named)
        self.timeline = before.timeline
        self.floor.touched |= before.floor.touched

    def _find_obstacles(self, cloud: PointCloud) -> None:
        """Update the obstacles and the floor cells below them where a pair has points.

        One or two isolated cells occupy nothing: phantoms directly in front of the cameras would
        hide everything behind them.
        """
        touched = self.columns.update(cloud.points)
        min_voxels = self.settings.recognition.min_voxels
        before = [one for one in self.obstacles if one.found is not None]
        found = find_obstacles(self.columns, self.observations, min_voxels, self.obstacles, touched)
        self.obstacles = with_names(found, before)
        patch = patches(self.columns.under)
        size = np.bincount(patch.ravel() + 1, weights=self.columns.number.ravel())
        under = self.columns.under & (size[patch + 1] >= MIN_CELLS)
        self.floor.occupied = binary_closing(under, NEIGHBOURS)

    def _named(self, obstacle: Obstacle) -> Obstacle:
        objects = recognise(obstacle.voxels, self.settings.recognition).objects
        largest = max(objects, key=lambda found: found.num_voxels, default=None)
        return replace(
            obstacle,
            found=largest,
            num_named=len(obstacle.voxels),
            num_before=obstacle.num_named,
            views_named=len(obstacle.bearings_rad),
        )

    def _detect(self, seen: Scan, above: PointCloud) -> None:
        """Update the obstacles that are not in the map."""
        points_xz = above.points[:, [0, 2]]
        new = above.select(~self._is_mapped(points_xz, sigma_of(above)))
        for detection in detections(new, seen.place, self.scales):
            self._note(detection)
        centres = np.array([one.centre for one in self.detections]).reshape(-1, 2)
        mapped = self._is_mapped(centres, np.array([one.sigma for one in self.detections]))
        unmapped = tuple(itertools.compress(self.detections, ~mapped))
        is_refuted = np.array([one.is_refuted(self.floor) for one in unmapped], dtype=bool)
        self.detections = tuple(itertools.compress(unmapped, ~is_refuted))
        self.refuted.extend(itertools.compress(unmapped, is_refuted))

    def _is_mapped(self, points_xz: Array, sigma: Array) -> Mask:
        """Mask (N,) of the points that belong, within their errors, to a mapped obstacle."""
        centres = np.array([one.centre for one in self.obstacles]).reshape(-1, 2)
        reach = np.array([one.radius for one in self.obstacles]) + self.scales.same_obstacle
        is_near = cdist(points_xz, centres) - reach <= np.reshape(sigma, (-1, 1))
        mapped: Mask = np.logical_or.reduce(is_near, axis=1)
        return mapped

    def _note(self, new: Detection) -> None:
        """Keep a detection; of two that may show the same obstacle, the more reliable one."""
        is_same = [self._may_be_one(old, new) for old in self.detections]
        others = (old for old, same in zip(self.detections, is_same, strict=True) if not same)
        same = itertools.compress(self.detections, is_same)
        self.detections = (*others, min([*same, new], key=lambda detection: detection.sigma))

    def _may_be_one(self, a: Detection, b: Detection) -> bool:
        apart = math.dist(a.centre, b.centre)
        margin = self.scales.same_obstacle
        return apart <= max(margin, a.radius, b.radius, 2.0 * (a.sigma + b.sigma))


def _is_due(obstacle: Obstacle) -> bool:
    is_open = widest_gap(obstacle.bearings_rad) > OPEN_SURE_RAD
    growth = (OPEN_GROWTH if is_open else KNOWN_GROWTH) if obstacle.is_sure else GROWTH
    has_grown = len(obstacle.voxels) > growth * obstacle.num_named
    num_views = len(obstacle.bearings_rad)
    may_change = obstacle.is_doubtful or (is_known(obstacle) and not obstacle.is_sure)
    is_seen_again = may_change and num_views > obstacle.views_named
    return (has_grown or is_seen_again) and num_views >= NUM_VIEWS


def with_names(obstacles: tuple[Obstacle, ...], named: list[Obstacle]) -> tuple[Obstacle, ...]:
    """The obstacles with their previous names, if they had one."""
    if not obstacles or not named:
        return tuple(_with_name(one, None) for one in obstacles)
    apart = cdist([one.centre for one in obstacles], [one.centre for one in named])
    nearest = [named[number] for number in apart.argmin(axis=1)]
    is_same = apart.min(axis=1) <= [one.radius for one in obstacles]
    return tuple(
        _with_name(one, old if same else None)
        for one, old, same in zip(obstacles, nearest, is_same, strict=True)
    )


def _with_name(obstacle: Obstacle, named: Obstacle | None) -> Obstacle:
    """The obstacle with the name of another one, and the evidence for that name."""
    if named is None:
        return replace(obstacle, found=None, num_named=0, num_before=0, views_named=0)
    if obstacle.found is named.found and obstacle.num_named == named.num_named:
        return obstacle
    return replace(
        obstacle,
        found=named.found,
        num_named=named.num_named,
        num_before=named.num_before,
        views_named=named.views_named,
    )
