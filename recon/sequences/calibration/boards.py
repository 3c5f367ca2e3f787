"""Calibration of a rig from pairs of images of a board."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, ReconError
from recon.files import atomic_path
from recon.geometry import pose
from recon.notices import notify
from recon.sequences.calibration.agreement import MAX_SPREAD, BoardPair, agreed, lens
from recon.sequences.calibration.cameras import Calibration, Camera
from recon.sequences.calibration.targets import STOP, Corners, Target
from recon.sequences.frames import Skipped
from recon.sequences.images import read_image
from recon.sequences.listing import Listed, list_pairs

MIN_PAIRS = 3
"""Fewer pairs leave the lenses undetermined."""
MIN_CORNERS = 8
"""Fewer corners common to both images constrain a lens too little."""
FINE_PX = 0.5
"""Residuals below this are not outliers."""
MAX_RMS_PX = 1.0
"""Maximum for a usable calibration; beyond, boards were mismatched."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoardCalibration:
    """A calibration and its residual on the boards."""

    calibration: Calibration
    rms_px: float
    """Root mean square reprojection error of the corners, both cameras."""
    num_pairs: int
    skipped: tuple[Skipped, ...] = ()
    """Pairs in which the board was not found in both images, with the reason."""
    dropped: tuple[str, ...] = ()
    """Names of outlier pairs."""


def calibrate(
    left_dir: Path, right_dir: Path, target: Target, *, force: bool = False
) -> BoardCalibration:
    """Calibrate a rig.

    Pairs that do not fit the rest (taken at different times, wrong corners) are left out and named.

    Parameters
    ----------
    left_dir, right_dir : Path
        Images of the board, paired by name.
    target : Target
        The board.
    force : bool
        Accept a calibration that is off by more than a pixel.

    Raises
    ------
    InputError
        If fewer than three pairs show the board.
    ReconError
        If the calibration does not explain the images.
    """
    found, skipped = _all_found(left_dir, right_dir, target)
    _check_number(len(found), target, skipped)
    kept, dropped = agreed(found, lens(found, "left"), lens(found, "right"), target.orders)
    if len(kept) < MIN_PAIRS:
        raise ReconError(
            f"{len(kept)} of {len(found)} pairs agree on the relative pose of the cameras, but "
            f"{MIN_PAIRS} are needed: are the images paired by time?"
        )
    solved, more = _solved(kept)
    dropped = sorted([*dropped, *more])
    if dropped:
        notify(
            "calibration-pairs-dropped",
            f"{len(dropped)} of {len(found)} pairs do not fit the others and are left out: "
            f"{', '.join(dropped)}",
        )
    if solved.rms_px > MAX_RMS_PX and not force:
        raise ReconError(
            f"the calibration is off by {solved.rms_px:.2f} px (root mean square), but at most "
            f"{MAX_RMS_PX:g} px can be used: check --board and the images, or give --force"
        )
    if solved.calibration.is_swapped:
        notify(
            "left-right-swapped",
            "the right camera is to the left of the left one: left and right are swapped",
        )
    return BoardCalibration(
        calibration=solved.calibration,
        rms_px=solved.rms_px,
        num_pairs=solved.num_pairs,
        skipped=tuple(skipped),
        dropped=tuple(dropped),
    )


def _all_found(
    left_dir: Path, right_dir: Path, target: Target
) -> tuple[list[BoardPair], list[Skipped]]:
    found: list[BoardPair] = []
    skipped = []
    for entry in list_pairs(left_dir, right_dir):
        try:
            found.append(_found(entry, target, found[0].size if found else None))
        except InputError as error:
            skipped.append(Skipped(entry.name, str(error)))
    return found, skipped


def _check_number(number: int, target: Target, skipped: Sequence[Skipped]) -> None:
    if number < MIN_PAIRS:
        first = f"; the first error: {skipped[0].reason}" if skipped else ""
        raise InputError(f"{number} pairs show a {target.name}, but {MIN_PAIRS} are needed{first}")


def _found(entry: Listed, target: Target, size: tuple[int, int] | None) -> BoardPair:
    """The corners of a board visible in both images, whose `size` is that of the first pair."""
    if entry.left is None or entry.right is None:
        raise InputError(f"it has no {'left' if entry.left is None else 'right'} image")
    left, right = read_image(entry.left), read_image(entry.right)
    wanted = size or (left.shape[1], left.shape[0])
    in_left = _corners(entry.left, left, target, wanted)
    in_right = _corners(entry.right, right, target, wanted)
    numbers, left_rows, right_rows = np.intersect1d(
        in_left.numbers, in_right.numbers, return_indices=True
    )
    points = target.points[numbers]
    if (
        len(numbers) < min(MIN_CORNERS, len(target.points))
        or np.linalg.matrix_rank(points[:, :2] - points[:, :2].mean(axis=0)) < 2
    ):
        raise InputError(f"its images show {len(numbers)} corners in common, which are too few")
    return BoardPair(
        name=entry.name,
        size=wanted,
        numbers=numbers,
        points=points,
        left=in_left.points_px[left_rows],
        right=in_right.points_px[right_rows],
    )


def _corners(
    path: Path, image: NDArray[np.uint8], target: Target, size: tuple[int, int]
) -> Corners:
    """The corners of a board in one image."""
    if image.shape[1::-1] != size:
        raise InputError(f"{path} has another size than the first image")
    corners = target.find(image)
    if corners is None:
        raise InputError(f"{path} shows no {target.name}")
    return corners


def _solved(pairs: list[BoardPair]) -> tuple[BoardCalibration, list[str]]:
    """The joint solution of both cameras, with outlier pairs removed one by one."""
    kept, dropped = [*pairs], list[str]()
    while True:
        solved, residuals = _solve(kept)
        worst = int(np.argmax(residuals))
        limit = max(MAX_SPREAD * float(np.median(residuals)), FINE_PX)
        if residuals[worst] <= limit or len(kept) <= MIN_PAIRS:
            return solved, dropped
        dropped.append(kept.pop(worst).name)


def _solve(pairs: Sequence[BoardPair]) -> tuple[BoardCalibration, NDArray[np.float64]]:
    """Solve each camera alone, then both with their relative pose, all parameters free."""
    size = pairs[0].size
    left, right = (lens(pairs, side) for side in ("left", "right"))
    solution = cv2.stereoCalibrateExtended(
        [pair.points for pair in pairs],
        [pair.left for pair in pairs],
        [pair.right for pair in pairs],
        left.matrix,
        left.distortion,
        right.matrix,
        right.distortion,
        size,
        np.eye(3),
        np.zeros((3, 1)),
        flags=cv2.CALIB_USE_INTRINSIC_GUESS,
        criteria=STOP,
    )
    rms, K_left, D_left, K_right, D_right, R, T = solution[:7]
    residuals = np.asarray(solution[-1]).max(axis=1)
    calibration = Calibration(
        left=Camera(matrix=K_left, distortion=D_left.ravel(), size=size),
        right=Camera(matrix=K_right, distortion=D_right.ravel(), size=size),
        T_right_left=pose(R, T.ravel()),
    )
    solved = BoardCalibration(calibration=calibration, rms_px=float(rms), num_pairs=len(pairs))
    return solved, residuals


def write_calibration(rig: Calibration, path: Path, rms_px: float | None = None) -> None:
    """Save as OpenCV YAML, readable by recon and OpenCV 4 and 5."""
    with atomic_path(path) as temporary:
        storage = cv2.FileStorage(str(temporary), cv2.FILE_STORAGE_WRITE)
        for name, number in zip(("image_width", "image_height"), rig.size or (), strict=False):
            storage.write(name, number)
        if rms_px is not None:
            storage.write("rms_px", rms_px)
        for name, matrix in (
            ("M1", rig.left.matrix),
            ("D1", rig.left.distortion[None]),
            ("M2", rig.right.matrix),
            ("D2", rig.right.distortion[None]),
            ("R", rig.T_right_left[:3, :3]),
            ("T", rig.T_right_left[:3, 3:]),
        ):
            # All two-dimensional: OpenCV 4 and 5 write and read vectors differently.
            storage.write(name, np.ascontiguousarray(matrix))
        storage.release()
