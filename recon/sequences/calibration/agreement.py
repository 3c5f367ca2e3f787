"""Consistency of board pairs: one rig geometry must explain them all."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.geometry import invert, pose
from recon.sequences.calibration.targets import Indices, Points

Array = NDArray[np.float64]

MAX_SPREAD = 3.0
"""Multiple of the median residual beyond which a pair is an outlier."""
ROUGH_PX = 3.0
"""Residuals below this are not outliers before the joint solution of both cameras."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoardPair:
    """One board seen by both cameras."""

    name: str
    size: tuple[int, int]
    """(width, height) of the images."""
    numbers: Indices
    """(N,) indices of the corners that both see."""
    points: Points
    """(N, 3) on the board."""
    left: Points
    """(N, 2)"""
    right: Points
    """(N, 2)"""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lens:
    """One camera by itself, with the pose of each board."""

    matrix: Array
    distortion: Array
    T_camera_board: tuple[Array, ...]


def lens(pairs: Sequence[BoardPair], side: str) -> Lens:
    """One camera, calibrated from all its boards."""
    seen = [getattr(pair, side) for pair in pairs]
    _, K, D, turns, steps = cv2.calibrateCamera(
        [pair.points for pair in pairs], seen, pairs[0].size, None, None
    )
    poses = [pose(cv2.Rodrigues(R)[0], t.ravel()) for R, t in zip(turns, steps, strict=True)]
    return Lens(matrix=K, distortion=D, T_camera_board=tuple(poses))


def agreed(
    pairs: Sequence[BoardPair], left: Lens, right: Lens, orders: Sequence[Indices]
) -> tuple[list[BoardPair], list[str]]:
    """The pairs with the fitting order of right corners, and the names of pairs that fit none.

    A chessboard that looks the same from both ends may be detected rotated in one camera. Every
    pair and order proposes a rig geometry; the one that explains most boards is chosen, and with it
    each board's order.
    """
    residuals = np.array([_residuals(pairs, left, right, T, orders)
                          for T in _offered(pairs, left, right, orders)])  # fmt: skip
    best = int(np.argmin(np.median(residuals.min(axis=2), axis=1)))
    fitting = residuals[best].min(axis=1)
    limit = max(MAX_SPREAD * float(np.median(fitting)), ROUGH_PX)
    kept, dropped = [], []
    for pair, choice, residual in zip(pairs, residuals[best].argmin(axis=1), fitting, strict=True):
        if residual > limit:
            dropped.append(pair.name)
        else:
            kept.append(replace(pair, right=_reordered(pair, orders[choice])))
    return kept, dropped


def _offered(
    pairs: Sequence[BoardPair], left: Lens, right: Lens, orders: Sequence[Indices]
) -> list[Array]:
    """`T_right_left` from every pair in every order of its right corners."""
    return [
        _right_pose(pair, right, order) @ invert(T_left_board)
        for pair, T_left_board in zip(pairs, left.T_camera_board, strict=True)
        for order in orders
    ]


def _right_pose(pair: BoardPair, right: Lens, order: Indices) -> Array:
    _, turn, step = cv2.solvePnP(
        pair.points, _reordered(pair, order), right.matrix, right.distortion
    )
    return pose(cv2.Rodrigues(turn)[0], step.ravel())


def _residuals(
    pairs: Sequence[BoardPair],
    left: Lens,
    right: Lens,
    T_right_left: Array,
    orders: Sequence[Indices],
) -> Array:
    """(P, O) root mean square distance, in the right images, of each pair in each order."""
    found = []
    for pair, T_left_board in zip(pairs, left.T_camera_board, strict=True):
        T = T_right_left @ T_left_board
        expected, _ = cv2.projectPoints(
            pair.points, cv2.Rodrigues(T[:3, :3])[0], T[:3, 3], right.matrix, right.distortion
        )
        offsets = [expected.reshape(-1, 2) - _reordered(pair, order) for order in orders]
        found.append([np.sqrt((offset**2).sum(axis=1).mean()) for offset in offsets])
    return np.array(found)


def _reordered(pair: BoardPair, order: Indices) -> Points:
    """The right corners in another order; partial boards stay unchanged."""
    return pair.right if len(order) != len(pair.right) else pair.right[order]
