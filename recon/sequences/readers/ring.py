"""Calibrated views around one object (Middlebury multi-view): neighbours form pairs."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.errors import InputError
from recon.geometry import invert, pose, transform
from recon.records import StereoPair
from recon.sequences.calibration.cameras import Calibration, Camera
from recon.sequences.calibration.rectification import common_axes, warping
from recon.sequences.calibration.rigid import made_rigid, say_rigid
from recon.sequences.depth import Image
from recon.sequences.frames import Frame, Recording, Skipped
from recon.sequences.images import read_image
from recon.sequences.readers.reader import Reader
from recon.sequences.text import read_lines
from recon.settings import SequenceSettings

Array = NDArray[np.float64]

MIN_ANGLE_DEG, MAX_ANGLE_DEG = 10.0, 35.0
"""Angle between the views of a pair, seen from the object: smaller ones give uncertain depth,
larger ones few matches."""
MARGIN_PX = 16
"""Margin around the object's box in the rectified images: the reach of filters and windows."""
BLACK, DARK = 20.0, 40.0
"""Grey levels of the background, and of the darkest parts of the object."""
BACKGROUND_BLUR_PX = 1.0
"""Suppresses single bright pixels of noise."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RingView:
    """One calibrated image."""

    path: Path
    camera: Camera
    T_world_cam: Array
    """(4, 4) in the world of the file, with y up."""


def is_ring(path: Path) -> bool:
    """True if `path` contains par.txt or NAME_par.txt."""
    return path.is_dir() and any(path.glob("*par.txt"))


def open_ring(path: Path, settings: SequenceSettings) -> Recording:
    """Pairs of neighbouring views, chosen by their angle about the object, not by their order.

    Most have a vertical baseline; rectification rotates them. The world is the file's own.
    """
    views, twins = distinct(read_views(next(iter(path.glob("*par.txt")))))
    box = read_box(path, views)
    near = neighbours(views, box.mean(axis=0))
    if not near:
        raise InputError(
            f"{path} contains no two views {MIN_ANGLE_DEG:g} to {MAX_ANGLE_DEG:g} degrees apart"
        )
    pairs = [_ring_pair(*views_of_pair, box) for views_of_pair in in_turn(near, box.mean(axis=0))]
    frames = [
        Frame(
            name=pair.name,
            stamp_s=float(number),
            load=partial(pair.load, float(number), settings.poses != "none"),
        )
        for number, pair in [*enumerate(pairs)][:: settings.every]
    ]
    highest = max(pair.max_disparity for pair in pairs)
    return Recording(frames, unneeded=twins, disparity_range=(0, highest))


def read_views(path: Path) -> list[RingView]:
    """Views of par.txt: a name, K, R and t (world to camera) on each line.

    Raises
    ------
    InputError
        With the line that is not a view.
    """
    views, errors = [], []
    for number, line in enumerate(read_lines(path), start=1):
        name, _, values = line.strip().partition(" ")
        if not values:
            continue
        try:
            numbers = np.array([float(value) for value in values.split()])
            K, R, t = (part.reshape(-1, 3) for part in np.split(numbers, [9, 18]))
            T_cam_world, off = made_rigid(name, pose(R, t[0]))
        except (ValueError, IndexError) as error:
            raise InputError(
                f"{path}, line {number}: 21 numbers (K, R, t) are needed after {name}"
            ) from error
        camera = Camera(matrix=K, distortion=np.zeros(0))
        errors.append(off)
        views.append(
            RingView(path=path.parent / name, camera=camera, T_world_cam=invert(T_cam_world))
        )
    if not views:
        raise InputError(f"{path} contains no views, but a name, K, R and t per line are needed")
    say_rigid(f"{path}: the rotation of a view", max(errors))
    return views


def distinct(views: Sequence[RingView]) -> tuple[list[RingView], list[Skipped]]:
    """The views without those that repeat the pose of an earlier one."""
    kept: list[RingView] = []
    twins = []
    for view in views:
        twin = next((k for k in kept if np.allclose(k.T_world_cam, view.T_world_cam)), None)
        if twin is None:
            kept.append(view)
        else:
            twins.append(Skipped(view.path.stem, f"it has the pose of {twin.path.stem}"))
    return kept, twins


def neighbours(views: Sequence[RingView], centre: Array) -> list[tuple[RingView, RingView]]:
    """All pairs of views whose angle about `centre` (3,) suits stereo."""
    chosen = []
    for first, second in combinations(views, 2):
        a, b = (view.T_world_cam[:3, 3] - centre for view in (first, second))
        angle = np.degrees(np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b)))
        if MIN_ANGLE_DEG <= angle <= MAX_ANGLE_DEG:
            chosen.append((first, second))
    return chosen


def in_turn(
    pairs: Sequence[tuple[RingView, RingView]], centre: Array
) -> list[tuple[RingView, RingView]]:
    """The pairs in order around `centre` (3,), so that consecutive pairs overlap.

    The plane of the ring is that of the largest spread of the camera positions.
    """
    middles = np.stack(
        [first.T_world_cam[:3, 3] + second.T_world_cam[:3, 3] for first, second in pairs]
    )
    spread = middles / 2 - centre
    across, along = np.linalg.svd(spread)[2][:2] @ spread.T
    return [pairs[row] for row in np.argsort(np.arctan2(across, along), kind="stable")]


def read_box(folder: Path, views: Sequence[RingView]) -> Array:
    """[[x, y, z] lowest, [x, y, z] highest] of the object, world units.

    The README states it as two bracketed triples; otherwise it is the cube around the common target
    of all views, as large as fits the narrowest view.
    """
    number = r"\s*(-?\d+\.?\d*(?:[eE]-?\d+)?)"
    triple = rf"\({number}[\s,]{number}[\s,]{number}\s*\)"
    for readme in sorted(folder.glob("README*")):
        corners = re.findall(triple, readme.read_text(errors="replace"))
        if len(corners) == 2:
            return np.array(corners, dtype=np.float64)
    return _common_cube(views)


def _common_cube(views: Sequence[RingView]) -> Array:
    origins = np.stack([view.T_world_cam[:3, 3] for view in views])
    axes = np.stack([view.T_world_cam[:3, 2] for view in views])
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    centre = np.linalg.solve(across.sum(0), (across @ origins[:, :, None]).sum(0)).ravel()
    depth = ((centre - origins) * axes).sum(1)
    half_view = [
        np.min(view.camera.matrix[:2, 2] / np.diag(view.camera.matrix)[:2]) for view in views
    ]
    half = float(np.min(depth * half_view)) / np.sqrt(3)
    return np.stack([centre - half, centre + half])


def blackened(image: Image) -> Image:
    """The image with its dark background set to black: noise has features, too.

    The gain rises from 0 to 1 between the two levels; a step would create an artificial edge.
    """
    brightness = image if image.ndim == 2 else image.max(axis=2)
    blurred = cv2.GaussianBlur(brightness, (0, 0), BACKGROUND_BLUR_PX).astype(np.float32)
    gain = np.clip((blurred - BLACK) / (DARK - BLACK), 0.0, 1.0)
    dark: Image = (image * (gain if image.ndim == 2 else gain[..., None])).astype(np.uint8)
    return dark


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _RingPair:
    """Two views and their rectification, centred on the object."""

    left: RingView
    right: RingView
    calibration: Calibration
    rotation: Array
    rig: StereoRig
    max_disparity: int

    @property
    def name(self) -> str:
        return f"{self.left.path.stem}-{self.right.path.stem}"

    def load(self, stamp_s: float, is_posed: bool) -> StereoPair:
        left, right = (blackened(read_image(view.path)) for view in (self.left, self.right))
        rectify = warping(self.calibration, left.shape[1::-1], self.rotation, self.rig)
        T_world_raw = self.left.T_world_cam if is_posed else None
        return rectify.pair(left, right, T_world_raw, stamp_s, self.name)


def _ring_pair(left: RingView, right: RingView, box: Array) -> _RingPair:
    T_right_left = invert(right.T_world_cam) @ left.T_world_cam
    calibration = Calibration(left=left.camera, right=right.camera, T_right_left=T_right_left)
    rotation = common_axes(T_right_left)
    rig, max_disparity = _box_rig(calibration, rotation, _corners_left(left, box))
    return _RingPair(
        left=left,
        right=right,
        calibration=calibration,
        rotation=rotation,
        rig=rig,
        max_disparity=max_disparity,
    )


def _corners_left(left: RingView, box: Array) -> Array:
    corners = np.array(np.meshgrid(*box.T)).reshape(3, 8).T
    return transform(invert(left.T_world_cam), corners)


def _box_rig(
    calibration: Calibration, rotation: Array, corners_left: Array
) -> tuple[StereoRig, int]:
    """The rig that just covers the box, farthest corner at disparity 0, and the largest one."""
    focal = float(np.mean(np.diag(calibration.left.matrix)[:2]))
    left = corners_left @ rotation.T
    right = left - [calibration.baseline, 0.0, 0.0]
    seen_left, seen_right = (focal * p[:, :2] / p[:, 2:] for p in (left, right))
    shift = seen_left[:, 0] - seen_right[:, 0]
    seen = np.concatenate([seen_left, seen_right + np.array([shift.min(), 0.0])])
    cx_left, cy = MARGIN_PX - seen.min(axis=0)
    width, height = np.ceil(np.ptp(seen, axis=0)) + 2 * MARGIN_PX
    rig = StereoRig(
        width=int(width),
        height=int(height),
        focal_px=focal,
        cx_left_px=float(cx_left),
        cx_right_px=float(cx_left + shift.min()),
        cy_px=float(cy),
        baseline=calibration.baseline,
        residual_px=calibration.residual_px,
    )
    return rig, int(np.ceil(np.ptp(shift)))


READER = Reader(fits=is_ring, open=open_ring)
