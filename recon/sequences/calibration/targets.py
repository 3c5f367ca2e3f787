"""Calibration targets: chessboards, and ChArUco boards, of which a part is enough."""

import re
from dataclasses import dataclass, field
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.sequences.depth import Image
from recon.sequences.pair_images import grey

Points = NDArray[np.float32]
Indices = NDArray[np.int64]

CORNER_WINDOW = (5, 5)
"""Half size of the window in which a corner is refined."""
STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-6)
MIN_CHARUCO_CORNERS = 4
MARKER_SHARE = 0.75
"""Default side of a marker, relative to the side of a square."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Corners:
    """Corners of a board in one image."""

    numbers: Indices
    """(N,) indices of the board's corners, ascending."""
    points_px: Points
    """(N, 2)"""


class Target(Protocol):
    """A board whose corners are known."""

    @property
    def name(self) -> str:
        """Its name in messages."""
        ...

    @property
    def points(self) -> Points:
        """(C, 3) all corners in the plane of the board, world units."""
        ...

    @property
    def orders(self) -> list[Indices]:
        """Orders (C,) in which the corners of the same board may be found."""
        ...

    def find(self, image: Image) -> Corners | None:
        """The corners visible in an image; None if there are too few."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Chessboard:
    """A chessboard, detected as a whole; its ends are indistinguishable."""

    columns: int
    rows: int
    """INNER corners, where four squares meet."""
    square: float
    """Side of a square, world units (metres); sets the unit of the baseline."""

    @property
    def name(self) -> str:
        """Its name in messages."""
        return f"whole board of {self.columns} x {self.rows} inner corners"

    @property
    def points(self) -> Points:
        """(C, 3) all corners in the plane of the board, world units."""
        return _grid(self.columns, self.rows, self.square)

    @property
    def orders(self) -> list[Indices]:
        """As found, rotated by half a turn, and by quarter turns if the board is square."""
        grid = np.arange(self.columns * self.rows).reshape(self.rows, self.columns)
        turns = range(4) if self.columns == self.rows else (0, 2)
        return [np.rot90(grid, turn).ravel() for turn in turns]

    def find(self, image: Image) -> Corners | None:
        """All corners, or None."""
        found, corners = cv2.findChessboardCorners(grey(image), (self.columns, self.rows))
        if not found:
            return None
        refined = cv2.cornerSubPix(
            grey(image), corners.reshape(-1, 1, 2), CORNER_WINDOW, (-1, -1), STOP
        )
        return Corners(numbers=np.arange(len(refined)), points_px=refined.reshape(-1, 2))


@dataclass(frozen=True, slots=True, kw_only=True)
class Charuco:
    """A chessboard with markers in its white squares, which identify every corner."""

    columns: int
    rows: int
    """SQUARES along a row and along a column."""
    square: float
    """Side of a square, world units."""
    marker: float
    """Side of a marker, world units."""
    dictionary: str | None = None
    """Name of OpenCV's marker dictionary; detected if None."""
    _seen_by: list[Any] = field(default_factory=list, compare=False, repr=False)
    """The detector that found the first board."""

    @property
    def name(self) -> str:
        """Its name in messages."""
        return f"part of a ChArUco board of {self.columns} x {self.rows} squares"

    @property
    def points(self) -> Points:
        """(C, 3) all corners in the plane of the board, world units."""
        return _grid(self.columns - 1, self.rows - 1, self.square)

    @property
    def orders(self) -> list[Indices]:
        """A single order, as the markers identify the corners."""
        return [np.arange((self.columns - 1) * (self.rows - 1))]

    def find(self, image: Image) -> Corners | None:
        """The corners between visible markers; the detector of the first board is reused."""
        best: Corners | None = None
        for detector in self._seen_by or self._detectors():
            found = _charuco_corners(detector, grey(image))
            if found is not None and (best is None or len(found.numbers) > len(best.numbers)):
                best, chosen = found, detector
        if best is not None and not self._seen_by:
            self._seen_by.append(chosen)
        return best

    def _detectors(self) -> list[Any]:
        """One detector per possible dictionary and pattern."""
        names = [self.dictionary] if self.dictionary else self._dictionaries()
        # Before OpenCV 4.6 boards of even rows began with a white square.
        patterns = (False, True) if self.rows % 2 == 0 else (False,)
        return [self._detector(name, pattern) for name in names for pattern in patterns]

    def _detector(self, dictionary: str, is_legacy: bool) -> Any:
        words = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
        board = cv2.aruco.CharucoBoard((self.columns, self.rows), self.square, self.marker, words)
        board.setLegacyPattern(is_legacy)
        return cv2.aruco.CharucoDetector(board)

    def _dictionaries(self) -> list[str]:
        """The smallest sufficient dictionary of each marker size: larger ones include it."""
        number = self.columns * self.rows // 2
        size = next((size for size in (50, 100, 250) if number <= size), 1000)
        return [*(f"DICT_{bits}X{bits}_{size}" for bits in (4, 5, 6, 7)), "DICT_APRILTAG_36h11"]


def _charuco_corners(detector: Any, image: Image) -> Corners | None:
    points, numbers, _, _ = detector.detectBoard(image)
    if numbers is None or len(numbers) < MIN_CHARUCO_CORNERS:
        return None
    rising = np.argsort(numbers.ravel())
    return Corners(
        numbers=numbers.ravel()[rising].astype(np.int64), points_px=points.reshape(-1, 2)[rising]
    )


def parse_target(text: str, square: float) -> Target:
    """A board of "9x6" (inner corners), or "charuco:7x5", "charuco:7x5:DICT_4X4_50:0.75" (squares).

    Raises
    ------
    InputError
        If the text is not one of these.
    """
    kind, _, rest = text.partition(":") if ":" in text else ("", "", text)
    counts, *options = rest.split(":")
    columns, _, rows = counts.partition("x")
    is_size = columns.isdecimal() and rows.isdecimal() and min(int(columns), int(rows)) >= 2
    if not is_size or max(int(columns), int(rows)) > 100 or kind not in ("", "charuco"):
        raise InputError(
            f"--board is {text!r:.60}, but inner corners such as 9x6, or charuco:7x5 (squares), "
            "are needed"
        )
    if not kind:
        return Chessboard(columns=int(columns), rows=int(rows), square=square)
    numbers = [float(word) for word in options if re.fullmatch(r"\d*\.?\d+", word)]
    names = [_dictionary(word) for word in options if not re.fullmatch(r"\d*\.?\d+", word)]
    marker = numbers[0] if numbers else MARKER_SHARE * square
    if marker >= square:  # a share of the square, not a length
        marker *= square
    if not 0 < marker < square:
        raise InputError(f"--board is {text!r:.60}, but a marker smaller than its square is needed")
    return Charuco(
        columns=int(columns),
        rows=int(rows),
        square=square,
        marker=marker,
        dictionary=names[0] if names else None,
    )


def _dictionary(word: str) -> str:
    name = word.upper().replace("APRILTAG_36H11", "APRILTAG_36h11")
    name = name if name.startswith("DICT_") else f"DICT_{name}"
    if not hasattr(cv2.aruco, name):
        raise InputError(f"dictionary is {word!r:.40}, but one of OpenCV's is needed (DICT_4X4_50)")
    return name


def _grid(columns: int, rows: int, square: float) -> Points:
    row, column = np.mgrid[:rows, :columns].reshape(2, -1)
    points: Points = (square * np.column_stack([column, row, 0 * row])).astype(np.float32)
    return points
