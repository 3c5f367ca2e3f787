"""Standpoints: from where a pair may have been taken, by a portrait of the map.

Analysis by synthesis: the map is drawn as a camera would see it, and the likelihood of the image is
that of its colours, on things and behind them. What is seen and what is not, outlines and textures
all speak at once.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from recon.camera import StereoRig
from recon.geometry import Array, pose, rotation_about_y, wrapped
from recon.localisation.drawing import Solids
from recon.localisation.graph import planar
from recon.localisation.look import Look
from recon.localisation.paint import Paint
from recon.localisation.portrait import Portrait
from recon.localisation.stance import Stance
from recon.localisation.summit import summit

COARSE_PX = 4
"""Side of the pixels of the first drawings, in pixels of the image ..."""
SHAPE_CELLS, TEXTURE_CELLS = 0.6, 0.3
"""... halved for things of which they cover more cells, where shapes or textures are compared."""
STANCE_DEG, PITCH_DEG = 2.5, 0.5
"""Greatest distance of a pitch from one of the stance, and step between those that are tried."""
RANGE_STEP, LEAST_RANGE, MOST_RANGE = 1.08, 0.6, 20.0
"""Factor between the distances that are tried; the first and last one, in sizes of the thing."""
BEARING_STEP_PX, ASIDE_SHARE = 16, 0.9
"""Step between the bearings at which a thing is tried, in pixels of the middle of the image, and
share of a thing that may be beside the image."""
SIDE_DEG, OTHER_SIDE_DEG = 2.0, 8.0
"""Turn about a thing between the sides that are tried, and between those that are kept."""
NUM_SIGHTINGS, NUM_DISTINCT, NUM_SIDES = 40, 14, 8
"""Distances and columns that are climbed, those of which all sides are tried, and sides kept."""
NUM_CLIMBED, NUM_REFINED, NUM_LAST = 24, 6, 3
"""Poses that are climbed in large pixels, in smaller ones, and in those of the image."""
ALIKE_SHARE, ALIKE_RAD = 0.04, 0.04
"""A thing is seen alike within this share of its distance, and from the same direction."""
NEAR_CELLS, NEAR_RAD = 0.3, 0.03
"""Climbed poses within this distance and turn are the same."""
FIRST_SHARE, LEAST_SHARE, NEARER = 1.0, 0.1, 0.0075
"""First and last step of a climb in pixels as drawn; step towards a thing for each pixel of the
image, as a share of its distance."""
PRECISE_PX = (0.5, 0.2, 0.1)
"""Last steps, in pixels of the image."""
MOST_ROUNDS, LEAST_GAIN = 6, 2.0
"""Number of rounds of the last steps, and the gain of log likelihood below which they end."""
MOST_DRAWN = 600
"""Number of drawings after which a climb ends."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Standpoint:
    """A pose from which a pair may have been taken."""

    T_world_left: Array
    thing: int
    """Number of the object that it looks at."""
    value: float
    """Log likelihood of the image, less that of any colours."""

    def is_apart(self, other: "Standpoint", length: float, angle: float) -> bool:
        """True if two poses differ by more than a length or an angle."""
        off = planar(self.T_world_left) - planar(other.T_world_left)
        return bool(math.hypot(off[0], off[1]) > length or abs(float(wrapped(off[2]))) > angle)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Standpoints:
    """A search of all poses of one stance."""

    portrait: Portrait
    stance: Stance

    def of(self, look: Look, pitch: float) -> list[Standpoint]:
        """The distinct poses that may be true, near a pitch, the likeliest first.

        Their values are those in the pixels of the image.
        """
        solids, paint = self.portrait.solids, self.portrait.paint
        found = self._sides(look, self._sighted(look, pitch))[:NUM_CLIMBED]
        found = self._distinct(
            self._climbed(look, one, solids, paint, self._coarse_px(look, one, TEXTURE_CELLS))
            for one in found
        )[:NUM_REFINED]
        climbed = (self._climbed(look, one, solids, paint, 2) for one in found)
        found = self._distinct(climbed)[:NUM_LAST]
        best, *others = self._distinct(self._one_round(look, one) for one in found)
        return [self._precise(look, best), *others]

    def pitch(self, look: Look) -> float:
        """The pitch, near those of the stance, at which the backdrop is as the image has it."""
        steps = np.radians(np.arange(-STANCE_DEG, STANCE_DEG + 1e-9, PITCH_DEG))
        # The nearest ones first: they count where nothing of the backdrop is seen.
        steps = steps[np.argsort(np.abs(steps), kind="stable")]
        tried = np.add.outer(self.stance.pitches, steps).ravel().tolist()
        return float(max(tried, key=lambda pitch: look.against(self.portrait.paint, pitch)[0]))

    def _coarse_px(self, look: Look, one: Standpoint, detail: float) -> int:
        """Side of the pixels in which a thing is drawn at first: finer if it is far away."""
        wide = detail * self.portrait.cell_size * look.rig.focal_px / self._away(one)
        return COARSE_PX if wide > COARSE_PX else COARSE_PX // 2

    def _away(self, one: Standpoint) -> float:
        offset = self.portrait.centre(one.thing) - one.T_world_left[:3, 3]
        return math.hypot(offset[0], offset[2])

    def _sighted(self, look: Look, pitch: float) -> list[Standpoint]:
        """Distances and columns at which some side of a thing may be seen."""
        found = []
        for thing in np.unique(self.portrait.thing).tolist():
            poses = list(self._facing(look.rig, thing, pitch))
            solids, plain = self.portrait.of_thing(thing)
            value = look.values(solids, plain, poses, COARSE_PX)
            found += [
                Standpoint(T_world_left=poses[row], thing=thing, value=float(value[row]))
                for row in np.argsort(-value, kind="stable")[:NUM_SIGHTINGS]
            ]
        climbed = [
            self._climbed(
                look, one, *self.portrait.of_thing(one.thing),
                self._coarse_px(look, one, SHAPE_CELLS),
            )
            for one in self._seen_alike(found)[:NUM_SIGHTINGS]
        ]  # fmt: skip
        return self._seen_alike(climbed)[:NUM_DISTINCT]

    def _facing(self, rig: StereoRig, thing: int, pitch: float) -> Iterator[Array]:
        """Poses on one side of a thing, at all distances, that see it at all columns."""
        centre, size = self.portrait.centre(thing), self.portrait.size(thing)
        steps = math.ceil(math.log(MOST_RANGE / LEAST_RANGE) / math.log(RANGE_STEP))
        for away in LEAST_RANGE * size * RANGE_STEP ** np.arange(steps):
            beside = ASIDE_SHARE * math.asin(min(size / away, 1.0))
            left = math.atan2(-rig.cx_left_px, rig.focal_px) - beside
            right = math.atan2(rig.width - rig.cx_left_px, rig.focal_px) + beside
            for bearing in np.arange(left, right, BEARING_STEP_PX / rig.focal_px).tolist():
                yield self.stance.at(np.array([centre[0] - away, centre[2], -bearing]), pitch)

    def _seen_alike(self, found: list[Standpoint]) -> list[Standpoint]:
        """One of the poses that see a thing alike, the likeliest first."""
        kept: list[Standpoint] = []
        for one in sorted(found, key=lambda one: -one.value):
            length = ALIKE_SHARE * self._away(one)
            if all(one.thing != k.thing or one.is_apart(k, length, ALIKE_RAD) for k in kept):
                kept.append(one)
        return kept

    def _sides(self, look: Look, sighted: list[Standpoint]) -> list[Standpoint]:
        """The best sides of things as they are sighted, the likeliest first."""
        turns, solids = np.radians(np.arange(0.0, 360.0, SIDE_DEG)), self.portrait.solids
        found = []
        for one in sighted:
            centre = self.portrait.centre(one.thing)
            poses = [orbited(one.T_world_left, centre, float(turn)) for turn in turns]
            value = look.values(
                solids, self.portrait.paint, poses, self._coarse_px(look, one, TEXTURE_CELLS)
            )
            found += [
                replace(one, T_world_left=poses[row], value=float(value[row]))
                for row in _summits(turns, value)
            ]
        return sorted(found, key=lambda one: -one.value)

    def _climbed(
        self, look: Look, one: Standpoint, solids: Solids, paint: Paint, block: int
    ) -> Standpoint:
        """The pose of highest value that ever smaller steps lead to."""
        T, share, number = one.T_world_left, FIRST_SHARE, 1
        best = look.values(solids, paint, [T], block)[0]
        while share > LEAST_SHARE and number < MOST_DRAWN:
            others = list(self._moved(look.rig, T, one.thing, share * block))
            value = look.values(solids, paint, others, block)
            row, number = int(value.argmax()), number + len(others)
            if value[row] > best:
                T, best = others[row], value[row]
            else:
                share /= 2.0
        return replace(one, T_world_left=T, value=float(best))

    def _precise(self, look: Look, one: Standpoint) -> Standpoint:
        """The pose of highest value nearby, to a small share of a pixel.

        Ways of moving depend on each other: where two things are seen far away, a pose slides
        along a ridge, round after round.
        """
        for _ in range(MOST_ROUNDS):
            before, one = one.value, self._one_round(look, one)
            if one.value - before < LEAST_GAIN:
                break
        return one

    def _one_round(self, look: Look, one: Standpoint) -> Standpoint:
        """A better pose nearby, and twice as far if that is better still."""
        unit = 1.0 / look.rig.focal_px

        def at(amounts: Array) -> Array:
            return self._near(one, *(unit * amounts).tolist())

        amounts = summit(lambda tried: self._value(look, at(tried)), 4, np.array(PRECISE_PX))
        found = [
            replace(one, T_world_left=T, value=self._value(look, T))
            for T in (at(amounts), at(2.0 * amounts))
        ]
        return max(found, key=lambda it: it.value)

    def _value(self, look: Look, T_world_left: Array) -> float:
        return float(look.values(self.portrait.solids, self.portrait.paint, [T_world_left], 1)[0])

    def _near(
        self, one: Standpoint, nearer: float, turn: float, orbit: float, tilt: float
    ) -> Array:
        """A pose after small moves towards the thing, around itself, around the thing and up."""
        T, centre = one.T_world_left, self.portrait.centre(one.thing)
        sizes = self._away(one) / self.portrait.size(one.thing)
        around = orbited(T, centre, orbit * sizes)
        towards = (centre - around[:3, 3]) * [1.0, 0.0, 1.0]
        R = rotation_about_y(turn) @ around[:3, :3] @ _tilted(tilt)
        return pose(R, around[:3, 3] + nearer * sizes * towards)

    def _moved(
        self, rig: StereoRig, T_world_left: Array, thing: int, step_px: float
    ) -> Iterator[Array]:
        """Poses moved towards a thing and aside, turned, tilted and turned about the thing."""
        angle, centre = step_px / rig.focal_px, self.portrait.centre(thing)
        R, eye = T_world_left[:3, :3], T_world_left[:3, 3]
        towards = (centre - eye) * [1.0, 0.0, 1.0]
        away = max(float(np.linalg.norm(towards)), self.portrait.cell_size)
        for way in (angle, -angle):
            yield pose(R, eye + way * rig.focal_px * NEARER * towards)
            yield pose(rotation_about_y(way) @ R, eye)
            yield pose(R, eye + way * away * R[:, 0])
            yield orbited(T_world_left, centre, way * away / self.portrait.size(thing))
        for way in (angle, -angle):
            yield pose(R @ _tilted(way), eye)

    def _distinct(self, found: Iterable[Standpoint]) -> list[Standpoint]:
        """The distinct poses, the likeliest first."""
        kept: list[Standpoint] = []
        length = NEAR_CELLS * self.portrait.cell_size
        for one in sorted(found, key=lambda one: -one.value):
            if all(one.is_apart(other, length, NEAR_RAD) for other in kept):
                kept.append(one)
        return kept


def orbited(T_world_left: Array, centre: Array, angle: float) -> Array:
    """A pose (4, 4) after a turn about the vertical through a point."""
    turn, pivot = rotation_about_y(angle), centre * [1.0, 0.0, 1.0]
    turned: Array = pose(turn, pivot - turn @ pivot) @ T_world_left
    return turned


def _tilted(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _summits(turns: Array, value: Array) -> list[int]:
    """Rows of the best turns, one of neighbouring ones."""
    chosen: list[int] = []
    for row in np.argsort(-value, kind="stable").tolist():
        apart = np.abs(wrapped(turns[chosen] - turns[row]))
        if (apart > math.radians(OTHER_SIDE_DEG)).all():
            chosen.append(row)
        if len(chosen) == NUM_SIDES:
            break
    return chosen
