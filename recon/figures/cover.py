"""Parts of an image that are covered by the drawing, which texts must avoid."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BLOCK_PX = 6
"""Side of the squares that are marked as covered or free."""


class Cover:
    """The squares of an image covered by dots of `radius_px` at (N, 2) pixels."""

    def __init__(self, at: Array, radius_px: Array | float, size: tuple[int, int]) -> None:
        shape = (size[1] // BLOCK_PX + 1, size[0] // BLOCK_PX + 1)
        steps = np.zeros((shape[0] + 1, shape[1] + 1))
        reach = np.broadcast_to(radius_px, len(at))[:, None]
        low = np.clip((at - reach) // BLOCK_PX, 0, shape[::-1]).astype(int)
        high = np.clip((at + reach) // BLOCK_PX + 1, 0, shape[::-1]).astype(int)
        for corner, sign in (((0, 0), 1), ((1, 1), 1), ((0, 1), -1), ((1, 0), -1)):
            x = (low, high)[corner[0]][:, 0]
            y = (low, high)[corner[1]][:, 1]
            np.add.at(steps, (y, x), sign)
        covered = steps.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0.5
        self._shape = shape
        self._sum = np.zeros((shape[0] + 1, shape[1] + 1))
        self._sum[1:, 1:] = covered.cumsum(axis=0).cumsum(axis=1)

    def area(self, boxes: Array) -> Array:
        """Covered area (S,), in square pixels, of boxes (S, 4): left, top, right, bottom."""
        low = np.clip(boxes[:, :2] // BLOCK_PX, 0, self._shape[::-1]).astype(int)
        high = np.clip(np.ceil(boxes[:, 2:] / BLOCK_PX), 0, self._shape[::-1]).astype(int)
        high = np.maximum(high, low)
        (left, top), (right, bottom) = low.T, high.T
        total = self._sum
        squares = total[bottom, right] - total[top, right] - total[bottom, left] + total[top, left]
        area: Array = squares * BLOCK_PX**2
        return area
