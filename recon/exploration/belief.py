"""Belief: the agent's estimate of its path, from its steps and the objects it saw.

Every pair adds a pose to a graph whose landmarks are the objects; returning to known objects
corrects the whole path.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from recon.exploration.floor import Array
from recon.exploration.scan import Detection, detections, field_of_view
from recon.exploration.world_model import WorldModel
from recon.geometry import invert, pose, rotation_about_y, transform, without_drift, wrapped
from recon.localisation.graph import FRONT_SHARE, Bearing, Graph, Link, planar, step_between
from recon.localisation.pairs import Shown, linked
from recon.mapping.pair import PairResult
from recon.records import PointCloud, StereoPair, View
from recon.settings import Settings, updated

AZIMUTH_SIGMA_RAD = math.radians(0.15)
MIDDLE_SHARE = 0.04
"""Standard deviation of the centre of an object's visible part, as a share of its radius."""
DISTANCE_SHARE = 0.06
"""The same for the distance to its front."""
EDGE_RAD = math.radians(1.0)
"""An object this close to the image border is cut off, so its centre is elsewhere."""
HIDDEN_SHARE = 0.5
"""Maximum offset of the visible part's centre from the object's, as a share of the hidden part."""
GATE, FAR_GATE = 3.0, 4.0
"""Standard deviations within which an object is a known one, and beyond which it is new."""
NEW, UNCLEAR = -1, -2
NUM_NEIGHBOURS, MIN_COSINE = 3, -0.2
"""Earlier pairs that a pair is registered to: those that see an object from less than 100 degrees
off."""
NUM_SIGMAS, MAX_CAUTION = 2.0, 1 / 3
"""Standard deviations of the position added to the distance from obstacles; at most this share of
the clearance."""
MOVED, TURNED_RAD = 0.2, math.radians(0.3)
"""Correction of the path, in cells and radians, beyond which the map is rebuilt."""


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


@dataclass(slots=True, kw_only=True, eq=False)
class Belief:
    """The graph of the walk so far, and its pairs."""

    settings: Settings
    sights: list[Sight] = field(default_factory=list)
    """All pairs, with their poses in the map."""
    graph: Graph | None = None
    _shown: list[Shown] = field(default_factory=list)

    @property
    def sigma(self) -> float:
        """Standard deviation of the position in its most uncertain direction, world units."""
        if self.graph is None:
            return 0.0
        return float(np.sqrt(np.linalg.eigvalsh(self.graph.covariance()[:2, :2])[-1]))

    @property
    def cautious(self) -> Settings:
        """The settings with the clearance increased by the uncertainty of the position."""
        clearance = self.settings.exploration.walk_clearance
        wide = clearance + min(NUM_SIGMAS * self.sigma, MAX_CAUTION * clearance)
        return updated(self.settings, {"exploration": {"walk_clearance": wide}})

    def correct(self, sight: Sight, model: WorldModel) -> Array:
        """Add the next pair; return the transform (4, 4) from intended to believed pose."""
        meant = sight.planar
        if self.graph is None:
            self.graph = Graph.at(meant, self._step_sigma)
        else:
            self.graph.walk(step_between(self.sights[-1].planar, meant))
        for detection in self._things(sight, model):
            self._note(detection, sight)
        self.graph.solve()
        self._shown.append(Shown.of(sight.pair, sight.cloud, self.settings.map))
        self._link()
        return _motion(meant, self.graph.poses[-1], sight)

    def _link(self) -> None:
        """Register the last pair to earlier ones that show the same."""
        assert self.graph is not None
        last = len(self._shown) - 1
        links = []
        for number in self._neighbours():
            poses = self.graph.poses[[number, last]]
            spread = self.graph.spread_between(number)
            found = linked(self._shown[number], self._shown[last], poses, spread)
            if found is not None:
                links.append(Link.between((number, last), *found))
        self.graph.links += links
        if links:
            self.graph.solve()

    def _neighbours(self) -> list[int]:
        """Numbers of the earlier pairs that see known objects from the most similar directions."""
        assert self.graph is not None
        last = len(self.graph.poses) - 1
        own = {bearing.landmark for bearing in self.graph.bearings if bearing.pose == last}
        apart: dict[int, float] = {}
        for bearing in self.graph.bearings:
            if bearing.pose < last and bearing.landmark in own:
                middle = self.graph.landmarks[bearing.landmark, :2]
                arms = middle - self.graph.poses[[bearing.pose, last], :2]
                lengths = np.hypot(*arms.T)
                cosine = float(arms[0] @ arms[1] / max(lengths.prod(), 1e-9))
                worth = cosine - 0.5 * abs(math.log(max(lengths[0], 1e-6) / max(lengths[1], 1e-6)))
                if cosine > MIN_COSINE:
                    apart[bearing.pose] = max(worth, apart.get(bearing.pose, -9.0))
        best = sorted(apart, key=lambda number: -apart[number])[:NUM_NEIGHBOURS]
        # The previous pair may show the same surface, known or not.
        return best if last - 1 in best or not last else [*best, last - 1]

    def keep(self, sight: Sight) -> Sight:
        """Record the pose of the last pair in the map."""
        self.sights.append(sight)
        return sight

    def outdated(self) -> list[Sight] | None:
        """All pairs at their current poses if these differ from the map; otherwise None."""
        assert self.graph is not None
        had = np.array([sight.planar for sight in self.sights]).reshape(-1, 3)
        off = self.graph.poses[: len(had)] - had
        off[:, 2] = wrapped(off[:, 2])
        limit = MOVED * self.settings.map.cell_size
        is_near = (np.hypot(*off.T[:2]) < limit) & (np.abs(off[:, 2]) < TURNED_RAD)
        if is_near.all():
            return None
        self.sights = [
            sight.moved(_motion(old, new, sight))
            for sight, old, new in zip(self.sights, had, self.graph.poses, strict=False)
        ]
        return [*self.sights]

    @property
    def _step_sigma(self) -> tuple[float, float]:
        """Of position and heading; never so small that nothing could be corrected."""
        motion, least = self.settings.motion, 1e-4
        return (
            max(motion.position_noise, least * self.settings.map.cell_size),
            max(math.radians(motion.heading_noise_deg), least),
        )

    def _things(self, sight: Sight, model: WorldModel) -> list[Detection]:
        """The objects in front of the cameras."""
        place = sight.view.position[[0, 2]]
        standing = model.standing(place, sight.cloud)
        return detections(standing, place, model.scales) if len(standing) else []

    def _note(self, seen: Detection, sight: Sight) -> None:
        """Add the sighting of an object, known or new."""
        assert self.graph is not None
        x, z, azimuth = sight.planar
        offset = seen.centre - [x, z]
        distance = float(np.hypot(*offset))
        bearing = float(wrapped(math.atan2(offset[1], offset[0]) - azimuth))
        half = math.atan2(seen.radius, distance)
        is_cut = abs(bearing) + half > field_of_view(sight.pair) / 2.0 - EDGE_RAD
        landmark = self._known(seen, bearing, distance)
        if landmark == NEW and (is_cut or seen.sigma > seen.radius):
            return
        if landmark == NEW:
            place, ahead = self._towards(bearing)
            middle = place + (distance + FRONT_SHARE * seen.radius) * ahead
            landmark = self.graph.add(middle, seen.radius)
        if landmark == UNCLEAR:
            return
        radius = float(self.graph.radii[landmark])
        hidden = max(0.0, radius - seen.radius) + (HIDDEN_SHARE * radius if is_cut else 0.0)
        self.graph.bearings.append(
            Bearing(
                pose=len(self.graph.poses) - 1,
                landmark=landmark,
                azimuth_rad=bearing,
                distance=distance,
                azimuth_sigma=math.hypot(
                    AZIMUTH_SIGMA_RAD, math.hypot(MIDDLE_SHARE * radius, hidden) / distance
                ),
                distance_sigma=math.hypot(
                    seen.sigma, DISTANCE_SHARE * radius + HIDDEN_SHARE * hidden
                ),
            )
        )

    def _towards(self, bearing: float) -> tuple[Array, Array]:
        """The last position (2,), and the direction (2,) of a bearing from there."""
        assert self.graph is not None
        x, z, heading = self.graph.poses[-1]
        azimuth = heading + bearing
        return np.array([x, z]), np.array([math.cos(azimuth), math.sin(azimuth)])

    def _known(self, seen: Detection, bearing: float, distance: float) -> int:
        """The landmark of a sighting, NEW, or UNCLEAR."""
        assert self.graph is not None
        if not len(self.graph.radii):
            return NEW
        place, ahead = self._towards(bearing)
        offset = self.graph.landmarks[:, :2] - place
        spread = self.graph.covariance()
        turned = math.sqrt(spread[2, 2]) * distance
        own = math.hypot(turned, math.sqrt(spread[:2, :2].trace()))
        hidden = np.maximum(self.graph.radii - seen.radius, 0.0)
        aside = np.abs(offset @ [-ahead[1], ahead[0]])
        along = np.abs(offset @ ahead - self.graph.landmarks[:, 2] - distance)
        reach = np.sqrt(own**2 + (0.1 * self.graph.radii) ** 2 + hidden**2)
        depth = np.sqrt(own**2 + (0.3 * self.graph.radii) ** 2 + seen.sigma**2 + hidden**2)
        off = np.hypot(aside / reach, along / depth)
        off[offset @ ahead <= 0.0] = np.inf
        order = np.argsort(off, kind="stable")[:2]
        if off[order[0]] > FAR_GATE:
            return NEW
        is_alone = len(order) < 2 or off[order[1]] > FAR_GATE
        return int(order[0]) if off[order[0]] < GATE and is_alone else UNCLEAR


def _motion(old: Array, new: Array, sight: Sight) -> Array:
    """The transform (4, 4) that moves a sight from one planar pose to another."""
    assert sight.pair.T_world_left is not None
    eye = sight.pair.T_world_left[:3, 3]
    there = np.array([new[0], eye[1], new[1]])
    turn = rotation_about_y(-float(wrapped(new[2] - old[2])))
    return pose(turn, there) @ invert(pose(np.eye(3), eye))


def belief_of(settings: Settings) -> Belief | None:
    """The belief of an agent with motion errors; None if motion is exact."""
    return None if settings.motion.is_exact else Belief(settings=settings)
