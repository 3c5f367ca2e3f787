"""Scales: the texture of a solid at levels from fine to coarse.

A pixel that shows something in the distance has the mean colour of all that it covers.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.localisation.repeats import SAME_LIKENESS, completed, repeats

FINER, LEVELS = 3, 5
"""Number of levels finer than the grid of a solid, and number of all levels."""
FINE_PX = 0.6
"""Least width of a texel, foreshortened, in an image that shows its colour."""
CLEAR_PX = 1.2
"""Least width of a texel in an image that shows the texture as it is."""
COLOUR_SIGMA = 8.0
"""Standard deviation of a channel of the same texel seen twice."""

Mask = NDArray[np.bool_]


class Level(NamedTuple):
    """Texels of one size."""

    mean: Array
    """(A, B, 3) RGB."""
    sigma: Array
    """(A, B) standard deviation of a channel."""
    is_clear: Mask
    """(A, B) True where a pair showed the texture as it is, or what it repeats exactly."""


def scales(width: Array, colour: Array) -> list[Level]:
    """Levels of a texture, the finest first, from widths (A, B) in pixels and colours (A, B, 3).

    Where no pair shows a level finely enough, it has the colours of the next one, which are off by
    as much as they are elsewhere.
    """
    seen = [(width, colour)]
    for _ in range(1, LEVELS):
        seen.append(_halved(*seen[-1]))
    coarse = seen[FINER][1], seen[FINER][0] > FINE_PX
    turns, same = repeats(*coarse), repeats(*coarse, SAME_LIKENESS)
    whole, spread = usual(*seen[-1])
    mean = np.broadcast_to(whole, seen[-1][1].shape)
    sigma = np.full(seen[-1][0].shape, spread)
    levels: list[Level] = []
    for number in reversed(range(LEVELS)):
        wide, colours = seen[number]
        _, clear = completed(colours, wide > CLEAR_PX, _scaled(same, number))
        colours, known = completed(colours, wide > FINE_PX, _scaled(turns, number))
        if levels:
            mean, sigma = (one.repeat(2, axis=0).repeat(2, axis=1) for one in levels[0][:2])
            if known.any():
                sigma = np.hypot(sigma, np.sqrt(np.square(colours - mean)[known].mean()))
        mean = np.where(known[..., None], colours, mean)
        sigma = np.where(known, COLOUR_SIGMA, sigma)
        levels.insert(0, Level(mean, sigma, clear))
    return levels


def _scaled(turns: Sequence[int], number: int) -> list[int]:
    """Turns of the grid of a solid, in columns of a level."""
    return [round(turn * 2.0 ** (FINER - number)) for turn in turns]


def _halved(width: Array, colour: Array) -> tuple[Array, Array]:
    """Texels twice as large."""
    around, along = width.shape
    blocks = width.reshape(around // 2, 2, along // 2, 2)
    seen = (blocks > 0.0).astype(np.float64)
    number = np.maximum(seen.sum(axis=(1, 3)), 1.0)
    colours = colour.reshape(around // 2, 2, along // 2, 2, 3) * seen[..., None]
    return 2.0 * blocks.sum(axis=(1, 3)) / number, colours.sum(axis=(1, 3)) / number[..., None]


def usual(width: Array, colour: Array) -> tuple[Array, float]:
    """Mean colour of what is seen, well if possible, and the standard deviation of a channel."""
    for least in (FINE_PX, 0.0):
        known = width > least
        if known.any():
            of = colour[known]
            return of.mean(axis=0), math.hypot(math.sqrt(of.var(axis=0).mean()), COLOUR_SIGMA)
    return np.full(3, 128.0), 80.0
