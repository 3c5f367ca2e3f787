"""Turns about a round thing: the pose of a pair by the texture that it shows.

The texture of the map is drawn as the pair would see it; corners tracked from there into the pair
are points that it has in common with a pair of the run, even if that saw them from another side.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from recon.geometry import Array, invert, pose, rotation_about_y, transform, wrapped
from recon.localisation.texture import Screen, Texture
from recon.records import StereoPair
from recon.sequences.odometry.motion import MAX_SIGMAS, MIN_TRACKS, linearise, refine_motion
from recon.sequences.odometry.places import Meeting, as_seen_by
from recon.sequences.odometry.tracking import GUIDED_LEVELS, Tracks, follow, seen_by_both
from recon.sequences.pair_images import grey

STEP_DEG = 2.0
"""Turns that are tried."""
NUM_TURNS = 3
"""Turns about one thing that are looked at closely."""
APART_DEG = 8.0
"""Distance of turns about one thing that are looked at."""
NUM_SOURCES = 2
"""Pairs of the run from which corners are tracked."""
NUM_CORNERS, CORNER_QUALITY, CORNER_SPACING_PX = 300, 0.01, 3
MARGIN_PX = 2
"""Width of the margin of a texture in which there are no corners."""
PITCHES_PX = np.arange(-4.0, 5.0)
"""Changes of the pitch that are tried first."""
NUM_STEPS, FIRST_PX, LEAST_PX, NEARER = 20, 1.0, 0.3, 0.01
"""Maximum number of steps to the best pose, first and last step in pixels, and step towards a
thing, as a share of its distance, for each pixel."""
REACH_CELLS = 0.8
"""Radius of a texel, drawn."""
MIN_SHARE = 0.5
"""Least share of the corners that agree on a motion."""
NUM_ROUNDS = 2
"""Number of times that the texture is drawn at the pose found last."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Turns:
    """Texture of a map, and the pairs that show it."""

    texture: Texture
    pairs: Sequence[StereoPair]

    def around(self, pair: StereoPair, screen: Screen, T_world_left: Array) -> list[Array]:
        """Poses (4, 4) around the thing that fills most of a view, where the texture agrees best.

        Without a thing in view there is none.
        """
        thing = self.ahead(pair, T_world_left)
        if thing is None:
            return []
        centre, texture = self.centre(thing), self.texture
        fit = partial(texture.fit, pair, screen)
        start = max(_pitched(T_world_left, pair.rig.focal_px), key=fit)
        angles = np.radians(np.arange(0.0, 360.0, STEP_DEG))
        poses = [_turned(start, centre, float(angle)) for angle in angles]
        told = partial(texture.evidence, pair, screen)
        evidence = np.array([told(T) for T in poses])
        return [
            _climbed(poses[row], centre, pair, told, STEP_DEG / 2.0)
            for row in _summits(angles, evidence)
        ]

    def ahead(self, pair: StereoPair, T_world_left: Array) -> int | None:
        """The thing that fills most of a view."""
        rows, seen = self.texture.seen_from(T_world_left, pair.rig)
        if not len(rows):
            return None
        fills = np.bincount(self.texture.thing[rows], seen[:, 2] ** 2 * seen[:, 3])
        return int(fills.argmax())

    def centre(self, thing: int) -> Array:
        """Middle (3,) of a thing."""
        of = self.texture.points[self.texture.thing == thing]
        middle: Array = (of.min(axis=0) + of.max(axis=0)) / 2.0
        return middle

    def measured(self, pair: StereoPair, T_world_left: Array) -> list[tuple[Array, Meeting]]:
        """Poses of pairs of the run, and the motions from there, by corners of their texture.

        Only those on which enough corners agree.
        """
        found = []
        for number in self._sources(pair, T_world_left):
            known = self.pairs[number]
            assert known.T_world_left is not None
            T, met = T_world_left, None
            for _ in range(NUM_ROUNDS):
                met = self._meet(known, pair, T)
                if met is None:
                    break
                T = known.T_world_left @ invert(met.T_second_first)
            if met is not None:
                found.append((known.T_world_left, met))
        return found

    def _sources(self, pair: StereoPair, T_world_left: Array) -> Iterator[int]:
        """Numbers of the pairs that show best what is in view."""
        rows, _ = self.texture.seen_from(T_world_left, pair.rig)
        number = np.bincount(self.texture.pair[rows], minlength=1)
        for one in np.argsort(-number, kind="stable")[:NUM_SOURCES].tolist():
            if number[one]:
                yield one

    def _meet(self, known: StereoPair, pair: StereoPair, T_world_left: Array) -> Meeting | None:
        assert known.T_world_left is not None
        tracks = self._tracks(known, pair, T_world_left)
        start = invert(T_world_left) @ known.T_world_left
        if tracks is None or len(tracks) < MIN_TRACKS:
            return None
        refined = refine_motion(start, tracks, pair.rig)
        if refined is None:
            return None
        agree = linearise(refined, tracks, pair.rig).distances < MAX_SIGMAS
        if agree.sum() < max(MIN_TRACKS, MIN_SHARE * len(tracks)):
            return None
        kept = tracks.select(agree)
        refined = refine_motion(refined, kept, pair.rig)
        if refined is None:
            return None
        return Meeting(
            T_second_first=refined, num_agreeing=len(kept), share=len(kept) / len(tracks),
            tracks=kept,
        )  # fmt: skip

    def _tracks(self, known: StereoPair, pair: StereoPair, T_world_left: Array) -> Tracks | None:
        """Corners of a known pair, tracked from its image drawn from a pose into another pair."""
        source_px = self._drawn(known, pair, T_world_left)
        if source_px is None:
            return None
        left, right = grey(pair.left), grey(pair.right)
        known_left, known_right = grey(known.left), grey(known.right)
        is_drawn = np.isfinite(source_px[..., 0])
        at = np.where(is_drawn[..., None], source_px, -1.0).astype(np.float32)
        drawn = cv2.remap(known_left, at[..., 0], at[..., 1], cv2.INTER_LINEAR)
        drawn = np.where(is_drawn, drawn, left)
        inner = cv2.erode(is_drawn.astype(np.uint8), np.ones((2 * MARGIN_PX + 1,) * 2, np.uint8))
        found = cv2.goodFeaturesToTrack(
            drawn, NUM_CORNERS, CORNER_QUALITY, CORNER_SPACING_PX, mask=inner
        )
        if found is None:
            return None
        corners = found.reshape(-1, 2)
        moved, is_moved = follow(drawn, left, corners, corners.copy(), GUIDED_LEVELS)
        place = np.rint(corners).astype(np.intp)
        from_px = source_px[place[:, 1], place[:, 0]].astype(np.float32)
        first, is_first = seen_by_both(known_left, known_right, from_px)
        second, is_second = seen_by_both(left, right, moved)
        both = is_moved & is_first & is_second
        return Tracks(
            first=as_seen_by(pair.rig, first.select(both), known.rig), second=second.select(both)
        )

    def _drawn(self, known: StereoPair, pair: StereoPair, T_world_left: Array) -> Array | None:
        """Points (H, W, 2) of a known image that each pixel of a pair shows; else NaN."""
        assert known.T_world_left is not None
        texture, rig = self.texture, pair.rig
        there, _ = texture.seen_from(known.T_world_left, known.rig)
        rows, seen = texture.seen_from(T_world_left, rig)
        both = np.isin(rows, there)
        rows, seen = rows[both], seen[both]
        if len(rows) < MIN_TRACKS:
            return None
        v, u = np.mgrid[0 : rig.height, 0 : rig.width]
        pixels = np.column_stack([u.ravel(), v.ravel()]).astype(np.float64)
        away, found = cKDTree(seen[:, :2]).query(pixels)
        nearest = np.asarray(found, np.intp)
        inside = away < REACH_CELLS * texture.cell_size * seen[nearest, 2]
        texel = rows[nearest[inside]]
        rays = rig.rays(pixels[inside]) @ T_world_left[:3, :3].T
        normal, eye = texture.normals[texel], T_world_left[:3, 3]
        far = np.einsum("ni,ni->n", normal, texture.points[texel] - eye)
        surface = eye + rays * (far / np.einsum("ni,ni->n", normal, rays))[:, None]
        back = transform(invert(known.T_world_left), surface)
        drawn = np.full((rig.height * rig.width, 2), np.nan)
        in_front = np.flatnonzero(inside)[back[:, 2] > 0.0]
        drawn[in_front] = known.rig.project_left(back[back[:, 2] > 0.0])
        return drawn.reshape(rig.height, rig.width, 2)


def _summits(angles: Array, evidence: Array) -> list[int]:
    """Rows of the turns that agree best, one of neighbouring ones."""
    chosen: list[int] = []
    for row in np.argsort(-evidence, kind="stable").tolist():
        apart = np.abs(wrapped(angles[chosen] - angles[row]))
        if evidence[row] > 0.0 and (apart > math.radians(APART_DEG)).all():
            chosen.append(row)
        if len(chosen) == NUM_TURNS:
            break
    return chosen


def _pitched(T_world_left: Array, focal_px: float) -> list[Array]:
    """Poses (4, 4) of other pitches, of which a shape tells least."""
    eye, R = T_world_left[:3, 3], T_world_left[:3, :3]
    turns = Rotation.from_rotvec([[up / focal_px, 0.0, 0.0] for up in PITCHES_PX])
    return [pose(R @ turn, eye) for turn in turns.as_matrix()]


def _climbed(
    T_world_left: Array,
    centre: Array,
    pair: StereoPair,
    value: Callable[[Array], float],
    turn_deg: float,
) -> Array:
    """The pose (4, 4) of highest value that ever smaller steps lead to.

    Parameters
    ----------
    centre : (3,) array
        Middle of the thing ahead.
    turn_deg : float
        Turn about the thing for each pixel.
    """
    best, share = value(T_world_left), FIRST_PX
    for _ in range(NUM_STEPS):
        moves = _moved(T_world_left, centre, share, pair.rig.focal_px, turn_deg)
        values = [value(T) for T in moves]
        row = int(np.argmax(values))
        if values[row] > best:
            T_world_left, best = moves[row], values[row]
        elif share > 2.0 * LEAST_PX:
            share /= 2.0
        else:
            break
    return T_world_left


def _moved(
    T_world_left: Array, centre: Array, step_px: float, focal_px: float, turn_deg: float
) -> list[Array]:
    """Poses turned sideways and up, nearer and farther, and turned about the thing ahead."""
    angle = step_px / focal_px
    eye, R = T_world_left[:3, 3], T_world_left[:3, :3]
    away = (centre - eye) * [1.0, 0.0, 1.0]
    moves = []
    for way in (-1.0, 1.0):
        moves += [
            pose(rotation_about_y(way * angle) @ R, eye),
            pose(R @ Rotation.from_rotvec([way * angle, 0.0, 0.0]).as_matrix(), eye),
            pose(R, eye + way * step_px * NEARER * away),
            _turned(T_world_left, centre, way * step_px * math.radians(turn_deg)),
        ]
    return moves


def _turned(T_world_left: Array, centre: Array, angle: float) -> Array:
    """A pose (4, 4) after a turn about the vertical through a point."""
    turn = rotation_about_y(angle)
    pivot = np.array([centre[0], 0.0, centre[2]])
    turned: Array = pose(turn, pivot - turn @ pivot) @ T_world_left
    return turned
