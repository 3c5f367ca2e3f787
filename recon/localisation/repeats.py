"""Repeats: textures that go several times around a solid are known where no pair has shown them.

Without them a side that was seen is preferred to one that looks the same and was not.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array

MIN_OVERLAP = 0.15
"""Least share of the texels that a turn must compare."""
MIN_LIKENESS, SAME_LIKENESS = 0.5, 0.9
"""Correlation, beyond the mean at each height, from which on a turn repeats a texture, and from
which on it does so exactly."""


def completed(
    colours: Array, seen: NDArray[np.bool_], turns: Sequence[int]
) -> tuple[Array, NDArray[np.bool_]]:
    """Colours (A, B, 3) of a grid that goes all round, and where they are known (A, B)."""
    colours, known = colours.copy(), seen.copy()
    for turn in turns:
        around, along = np.nonzero(~known)
        there = (around - turn) % len(known)
        new = known[there, along]
        around, along, there = around[new], along[new], there[new]
        colours[around, along], known[around, along] = colours[there, along], True
    return colours, known


def repeats(
    colours: Array, seen: NDArray[np.bool_], least_likeness: float = MIN_LIKENESS
) -> list[int]:
    """Turns, in columns, that repeat a texture (A, B, 3) where it is seen, most alike first."""
    number = np.maximum(seen.sum(axis=0), 1)
    beyond = colours - np.einsum("abc,ab->bc", colours, seen.astype(np.float64)) / number[:, None]
    beyond = np.where(seen[..., None], beyond, 0.0)
    turns = np.arange(1, len(colours))
    likeness = np.array([_likeness(beyond, seen, int(turn)) for turn in turns])
    alike = turns[likeness > least_likeness]
    # Not those that only are near to no turn at all.
    least = _blur(beyond, seen)
    far = alike[(alike > least) & (alike < len(colours) - least)]
    return [int(turn) for turn in sorted(far, key=lambda turn: -likeness[turn - 1])]


def _likeness(beyond: Array, seen: NDArray[np.bool_], turn: int) -> float:
    both = seen & np.roll(seen, turn, axis=0)
    if both.mean() < MIN_OVERLAP:
        return 0.0
    one, other = beyond[both], np.roll(beyond, turn, axis=0)[both]
    size = float(np.sqrt((one**2).sum() * (other**2).sum()))
    return float((one * other).sum()) / size if size > 0.0 else 0.0


def _blur(beyond: Array, seen: NDArray[np.bool_]) -> int:
    """Turn up to which a texture is like itself."""
    for turn in range(1, len(beyond) // 2):
        if _likeness(beyond, seen, turn) < MIN_LIKENESS:
            return turn
    return len(beyond) // 2
