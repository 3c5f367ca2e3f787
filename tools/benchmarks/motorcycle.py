"""The box of the motorcycle compared with that of its true points, in a hand-drawn mask."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from skimage.draw import polygon2mask

import recon
from benchmarks import Measurement
from recon.geometry import transform
from recon.recognition.segments.boxes import upright_box
from recon.recognition.segments.ground import level_plane

PAIR = Path(__file__).parents[2] / "data" / "motorcycle"
BIKE = (
    (122, 305), (130, 270), (158, 246), (112, 246), (92, 215), (95, 200), (112, 193), (140, 200),
    (138, 160), (150, 147), (165, 152), (168, 165), (240, 172), (285, 192), (355, 190), (370, 172),
    (358, 168), (383, 148), (332, 135), (340, 122), (375, 114), (385, 128), (430, 140), (470, 130),
    (490, 105), (495, 78), (512, 80), (520, 95), (545, 120), (565, 130), (570, 118), (583, 122),
    (580, 138), (563, 142), (555, 175), (545, 190), (575, 255), (600, 268), (640, 290), (645, 305),
    (620, 312), (665, 345), (683, 385), (675, 430), (640, 450), (600, 440), (545, 405), (515, 350),
    (505, 310), (525, 288), (500, 225), (490, 245), (478, 285), (475, 310), (460, 350), (420, 378),
    (355, 382), (348, 405), (325, 435), (325, 385), (330, 370), (280, 360), (255, 395), (210, 402),
    (165, 390), (135, 355),
)  # fmt: skip
"""Outline in the left image, (u, v)."""
FLOOR = ((0, 425), (120, 425), (300, 455), (500, 460), (620, 480), (620, 498), (0, 498))
"""Bare floor before it."""
SEEN_THROUGH = 2.9
"""Depth, metres, beyond which points inside the outline are seen through wheels and frame."""
ON_FLOOR = 0.03
"""Height, metres, up to which points inside the outline are of the floor, seen between the wheels:
these few would double the width."""
AXES = ("length", "height", "width")


def measure(quick: bool) -> Iterator[Measurement]:
    """Measure the relative errors of the sizes of the largest object."""
    if not (PAIR / "disp_left.pfm").is_file():
        return
    done = recon.reconstruct(PAIR, quality="fast" if quick else "best")
    found = max(done.objects, key=lambda one: one.num_voxels)
    assert found.box is not None
    for name, own, true in zip(AXES, ordered(found.box.sizes), ordered(true_sizes()), strict=True):
        yield Measurement(
            name=f"motorcycle.{name}_error",
            value=float(abs(own / true - 1.0)),
            unit=f"of {true:.3f} m (bar 0.25)",
            better="lower",
            tolerance=0.5,
        )


def ordered(sizes: np.ndarray) -> np.ndarray:
    """Sort length, height and width of an upright box."""
    return np.array([max(sizes[0], sizes[2]), sizes[1], min(sizes[0], sizes[2])])


def true_sizes() -> np.ndarray:
    """Compute the sizes of the upright box around the true points of the bike."""
    (pair,) = recon.open_sequence(PAIR)
    points = true_points(pair)
    floor = points[polygon2mask(points.shape[:2], np.array(FLOOR)[:, ::-1])]
    outline = polygon2mask(points.shape[:2], np.array(BIKE)[:, ::-1])
    bike = points[outline & (points[..., 2] > -SEEN_THROUGH)]
    T_level_world = level_plane(floor[np.isfinite(floor).all(axis=1)][::20])
    assert T_level_world is not None
    level = transform(T_level_world, bike[np.isfinite(bike).all(axis=1)])
    return upright_box(level[level[:, 1] > ON_FLOOR]).sizes


def true_points(pair: recon.StereoPair) -> np.ndarray:
    """Compute points (H, W, 3) from the true disparity, y up, -z forward, NaN where unknown."""
    disparity = cv2.imread(str(PAIR / "disp_left.pfm"), cv2.IMREAD_UNCHANGED).astype(np.float64)
    # Unknown ones are infinite, which is a depth of 0.
    disparity[~np.isfinite(disparity)] = np.nan
    height, width = disparity.shape
    uv = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).reshape(-1, 2)
    points = pair.rig.triangulate(uv.astype(np.float64), disparity.ravel())
    return transform(pair.T_world_left, points).reshape(height, width, 3)
