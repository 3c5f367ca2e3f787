"""Contours: solids at the places and of the sizes that their outlines in images show.

Solids that are fitted to the cells of a map are off by a tenth of a cell and more. The poses of a
run are known far better, and so is where in its images a thing ends.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.localisation.cameras import camera_of
from recon.localisation.drawing import Camera, Drawn, Solids, draw
from recon.localisation.likelihood import UNSEEN, values
from recon.localisation.paint import Paint
from recon.localisation.revolved import squared_radii
from recon.localisation.summit import summit
from recon.records import StereoPair, as_rgb

NUM_SIGHTS, MIN_PX = 8, 60
"""Maximum number of images a thing is fitted to, and fewest pixels that show it in one."""
LARGE_PX = 16_000
"""Number of pixels from which on an image is halved."""
AROUND_CELLS, AROUND_PX = 0.5, 2
"""Width of the surroundings of a thing that are compared."""
BESIDE_PX = 2
"""Width of what is beside an outline, on either side."""
STEPS_CELLS = (0.3, 0.2, 0.1, 0.05, 0.025)
"""Steps of the fit."""
SIGMA_CELLS = 0.15
"""Standard deviation of a measure of a solid before its outlines are known."""
JOINT_CELLS = 0.1
"""Distance of the ends of two solids that are one joint."""


class Changes(NamedTuple):
    """Independent changes of solids, by an amount of 1."""

    shift: Array
    """(K, S, 3) of the origin."""
    ends: Array
    """(K, S, 2) along the axis."""
    radii: Array
    """(K, S, 2) at the ends."""


class _Sight(NamedTuple):
    """The part of an image around a thing."""

    image: Array
    camera: Camera
    poses: Array
    """(1, 4, 4)"""
    block: int


def fitted(
    solids: Solids,
    thing: NDArray[np.intp],
    paint: Paint,
    pairs: Sequence[StereoPair],
    cell_size: float,
    *,
    beside_only: bool = False,
) -> Solids:
    """The solids at which the images of pairs, at their poses, are likeliest.

    Parameters
    ----------
    solids : Solids
    thing : (S,) array
        Number of each solid's object; those of an object move and join together.
    paint : Paint
    pairs : sequence of StereoPair
    cell_size : float
        World units.
    beside_only : bool
        Compare pixels beside outlines only: the texture, taken from the same images, is as they
        have it wherever a solid was.
    """
    drawn = [_drawn(thing, solids, pair) for pair in pairs]
    for number in np.unique(thing).tolist():
        sights = _sights(number, pairs, drawn, cell_size, beside_only)
        if sights:
            changes = _changes(solids, np.flatnonzero(thing == number), cell_size)
            solids = _likeliest(solids, changes, sights, paint, cell_size)
    return solids


def changed(solids: Solids, changes: Changes, amounts: Array) -> Solids:
    """Solids after so much (K,) of changes."""
    shift, ends, radii = (np.tensordot(amounts, one, 1) for one in changes)
    origin, ends = solids.origin + shift, solids.ends + ends
    radii = np.maximum(_radii(solids) + radii, 0.0)
    is_ball = solids.radius_sq[:, 2] < 0.0
    origin += np.where(is_ball, ends.mean(axis=1), 0.0)[:, None] * solids.frame[:, 2]
    half = np.maximum(ends[:, 1] - ends[:, 0], 1e-9) / 2.0
    ends = np.where(is_ball[:, None], np.multiply.outer(half, [-1.0, 1.0]), ends)
    return solids._replace(
        origin=origin,
        ends=ends,
        radius_sq=squared_radii(is_ball, ends, radii),
        reach=np.hypot(radii.max(axis=1), np.abs(ends).max(axis=1)),
    )


def _radii(solids: Solids) -> Array:
    """Radii (S, 2) at the ends; those of balls are their widest."""
    at = np.where(solids.radius_sq[:, 2:] < 0.0, 0.0, solids.ends)
    k0, k1, k2 = solids.radius_sq.T[:, :, None]
    return np.asarray(np.sqrt(np.maximum(k0 + k1 * at + k2 * at**2, 0.0)), np.float64)


def _drawn(thing: NDArray[np.intp], solids: Solids, pair: StereoPair) -> Drawn:
    """An image of the solids as a pair shows them, with numbers of objects instead of theirs."""
    assert pair.T_world_left is not None
    drawn: Drawn = draw(solids, camera_of(pair.T_world_left, pair.rig), 1)
    return drawn._replace(solid=np.where(drawn.solid >= 0, thing[drawn.solid], -1))


def _sights(
    number: int,
    pairs: Sequence[StereoPair],
    drawn: Sequence[Drawn],
    cell_size: float,
    beside_only: bool,
) -> list[_Sight]:
    """The images that show most of an object."""
    num_px = np.array([np.count_nonzero(one.solid == number) for one in drawn])
    best = np.argsort(-num_px, kind="stable")[:NUM_SIGHTS]
    return [
        _cut(pairs[row], drawn[row].solid == number, drawn[row].depth, cell_size, beside_only)
        for row in best
        if num_px[row] >= MIN_PX
    ]


def _cut(
    pair: StereoPair,
    mask: NDArray[np.bool_],
    depth: Array,
    cell_size: float,
    beside_only: bool,
) -> _Sight:
    """The part of an image around what a mask (H, W) shows."""
    assert pair.T_world_left is not None
    cells_px = cell_size * pair.rig.focal_px / float(np.median(depth[mask]))
    margin = AROUND_PX + math.ceil(AROUND_CELLS * cells_px)
    row, column = np.nonzero(mask)
    top, left = max(row.min() - margin, 0), max(column.min() - margin, 0)
    window = slice(top, row.max() + margin + 1), slice(left, column.max() + margin + 1)
    image = as_rgb(pair.left)[window]
    block = 1 if image.shape[0] * image.shape[1] < LARGE_PX else 2
    height, width = image.shape[0] // block, image.shape[1] // block
    image = image[: height * block, : width * block]
    smaller = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
    smaller = smaller.astype(np.float64)
    if beside_only:
        shown = cv2.resize(mask[window].astype(np.uint8), (width, height))
        kernel = np.ones((2 * BESIDE_PX + 1,) * 2, np.uint8)
        beside = cv2.dilate(shown, kernel) - cv2.erode(shown, kernel)
        smaller[beside == 0] = UNSEEN
    camera = camera_of(pair.T_world_left, pair.rig)
    return _Sight(
        image=smaller,
        camera=camera._replace(
            cx_px=camera.cx_px - left, cy_px=camera.cy_px - top,
            width=width * block, height=height * block,
        ),
        poses=pair.T_world_left[None],
        block=block,
    )  # fmt: skip


def _changes(solids: Solids, rows: NDArray[np.intp], cell_size: float) -> Changes:
    """Possible changes of an object: of its place, its joints along outlines, and its radii."""
    found = [_moved(solids, rows, across) for across in (0, 1)]
    found += [_lengthened(solids, joint) for joint in _joints(solids, rows, cell_size)]
    for row in rows:
        is_cone = solids.radius_sq[row, 2] > 0.0
        found += (
            [_widened(solids, row, [end]) for end in (0, 1)]
            if is_cone
            else [_widened(solids, row, [0, 1])]
        )
    return Changes(*(np.array(one) for one in zip(*found, strict=True)))


def _none(solids: Solids) -> Changes:
    return Changes(*(np.zeros((len(solids.origin), number)) for number in (3, 2, 2)))


def _moved(solids: Solids, rows: NDArray[np.intp], across: int) -> Changes:
    change = _none(solids)
    change.shift[rows] = solids.frame[rows[0], across]
    return change


def _lengthened(solids: Solids, joint: list[tuple[int, int]]) -> Changes:
    """A joint of ends is moved along the axis of the first; cones widen as they go on."""
    change, radii = _none(solids), _radii(solids)
    first, _ = joint[0]
    for row, end in joint:
        along = float(solids.frame[row, 2] @ solids.frame[first, 2])
        slope = (radii[row, 1] - radii[row, 0]) / np.ptp(solids.ends[row])
        change.ends[row, end], change.radii[row, end] = along, along * slope
    return change


def _widened(solids: Solids, row: int, ends: list[int]) -> Changes:
    change = _none(solids)
    change.radii[row, ends] = 1.0
    return change


def _joints(
    solids: Solids, rows: NDArray[np.intp], cell_size: float
) -> list[list[tuple[int, int]]]:
    """Solid and end of all ends that are in one place."""
    joints: list[tuple[Array, list[tuple[int, int]]]] = []
    for row in rows.tolist():
        for end in (0, 1):
            at = solids.origin[row] + solids.ends[row, end] * solids.frame[row, 2]
            near = [
                who for there, who in joints if np.linalg.norm(at - there) < JOINT_CELLS * cell_size
            ]
            if near:
                near[0].append((row, end))
            else:
                joints.append((at, [(row, end)]))
    return [who for _, who in joints]


def _likeliest(
    solids: Solids, changes: Changes, sights: list[_Sight], paint: Paint, cell_size: float
) -> Solids:
    def value(amounts: Array) -> float:
        there = changed(solids, changes, amounts)
        likely = sum(
            one.block**2 * values(one.image, there, paint, one.camera, one.poses)[0]
            for one in sights
        )
        return float(likely - 0.5 * np.square(amounts / (SIGMA_CELLS * cell_size)).sum())

    steps = cell_size * np.array(STEPS_CELLS)
    return changed(solids, changes, summit(value, len(changes.shift), steps))
