"""A rig's calibration from pairs of images of a chessboard."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.files import atomic_path
from recon.geometry import pose
from recon.sequences.calibration.cameras import Calibration, Camera
from recon.sequences.frames import Skipped
from recon.sequences.images import Image, read_image
from recon.sequences.listing import Listed, list_pairs

Points = NDArray[np.float32]

MIN_PAIRS = 3
"""Fewer leave the lenses undetermined."""
CORNER_WINDOW = (5, 5)
"""Half of the square in which a corner is refined."""
STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-6)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoardCalibration:
    """A calibration and how well it explains the boards."""

    calibration: Calibration
    rms_px: float
    """Root mean square distance of corners to where the calibration puts them, both cameras."""
    num_pairs: int
    skipped: tuple[Skipped, ...]
    """Pairs in which the board was not found by both eyes, and why."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Corners:
    """The corners of one board, in both images."""

    left: Points
    right: Points
    size: tuple[int, int]


def calibrate(
    left_dir: Path, right_dir: Path, board: tuple[int, int], square: float
) -> BoardCalibration:
    """Calibrate a rig.

    Parameters
    ----------
    left_dir, right_dir : Path
        Images of the board, paired by name.
    board : (columns, rows)
        INNER corners, where four squares meet.
    square : float
        Side of a square, world units (metres); sets the unit of the baseline.

    Raises
    ------
    InputError
        Where fewer than three pairs show the whole board.
    """
    found: list[_Corners] = []
    skipped = []
    for entry in list_pairs(left_dir, right_dir):
        try:
            found.append(_find(entry, board, found[0].size if found else None))
        except InputError as error:
            skipped.append(Skipped(entry.name, str(error)))
    if len(found) < MIN_PAIRS:
        first = f"; the first fault: {skipped[0].reason}" if skipped else ""
        raise InputError(
            f"{len(found)} pairs show a whole board of {board[0]} x {board[1]} inner corners, "
            f"but {MIN_PAIRS} are needed{first}"
        )
    return _solve(found, _board_points(board, square), tuple(skipped))


def _find(entry: Listed, board: tuple[int, int], size: tuple[int, int] | None) -> _Corners:
    if entry.left is None or entry.right is None:
        raise InputError(f"it has no {'left' if entry.left is None else 'right'} image")
    left, right = read_image(entry.left), read_image(entry.right)
    for path, image in ((entry.left, left), (entry.right, right)):
        if image.shape[1::-1] != (size or left.shape[1::-1]):
            raise InputError(f"{path} has another size than the first image")
    return _Corners(
        left=_corners(left, board, entry.left),
        right=_corners(right, board, entry.right),
        size=(left.shape[1], left.shape[0]),
    )


def _corners(image: Image, board: tuple[int, int], path: Path) -> Points:
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    found, corners = cv2.findChessboardCorners(grey, board)
    if not found:
        raise InputError(f"{path} shows no whole board of {board[0]} x {board[1]} inner corners")
    refined: Points = cv2.cornerSubPix(
        grey, corners.reshape(-1, 1, 2), CORNER_WINDOW, (-1, -1), STOP
    )
    return refined


def _board_points(board: tuple[int, int], square: float) -> Points:
    """(N, 3) corners of the board in its own plane."""
    row, column = np.mgrid[: board[1], : board[0]].reshape(2, -1)
    points: Points = (square * np.column_stack([column, row, 0 * row])).astype(np.float32)
    return points


def _solve(found: list[_Corners], points: Points, skipped: tuple[Skipped, ...]) -> BoardCalibration:
    """Each camera alone first, then both with the step between them, all numbers free."""
    boards, size = [points] * len(found), found[0].size
    lefts, rights = [corners.left for corners in found], [corners.right for corners in found]
    starts = [cv2.calibrateCamera(boards, seen, size, None, None)[1:3] for seen in (lefts, rights)]
    rms, K_left, D_left, K_right, D_right, R, T, _, _ = cv2.stereoCalibrate(
        boards,
        lefts,
        rights,
        *starts[0],
        *starts[1],
        size,
        flags=cv2.CALIB_USE_INTRINSIC_GUESS,
        criteria=STOP,
    )
    calibration = Calibration(
        left=Camera(matrix=K_left, distortion=D_left.ravel(), size=size),
        right=Camera(matrix=K_right, distortion=D_right.ravel(), size=size),
        T_right_left=pose(R, T.ravel()),
    )
    return BoardCalibration(
        calibration=calibration, rms_px=float(rms), num_pairs=len(found), skipped=skipped
    )


def write_calibration(result: BoardCalibration, path: Path) -> None:
    """Save as OpenCV's YAML, which recon and OpenCV 4 and 5 read."""
    rig = result.calibration
    width, height = rig.size or (0, 0)
    with atomic_path(path) as temporary:
        storage = cv2.FileStorage(str(temporary), cv2.FILE_STORAGE_WRITE)
        for name, number in (("image_width", width), ("image_height", height)):
            storage.write(name, number)
        storage.write("rms_px", result.rms_px)
        for name, matrix in (
            ("M1", rig.left.matrix),
            ("D1", rig.left.distortion[None]),
            ("M2", rig.right.matrix),
            ("D2", rig.right.distortion[None]),
            ("R", rig.T_right_left[:3, :3]),
            ("T", rig.T_right_left[:3, 3:]),
        ):
            # Two-dimensional all: OpenCV 4 and 5 write and read vectors differently.
            storage.write(name, np.ascontiguousarray(matrix))
        storage.release()
