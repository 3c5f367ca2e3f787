"""Odds: how much likelier an image is at one pose than at another, in a portrait.

A portrait is not perfect: its errors are those of whole surfaces, not of single pixels, so that the
number of pixels makes little surer. Log likelihoods count about as means over the pixels that show
an object. Errors of two objects are independent: a small one beside a large one tells apart two
sides of that which look the same.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.special import logsumexp

from recon.geometry import Array
from recon.localisation.drawing import Drawn, Indices
from recon.localisation.look import Look
from recon.localisation.paint import Paint
from recon.localisation.portrait import Portrait
from recon.localisation.standpoints import Standpoint

PER_E, OUTLINE_PER_E = 0.03, 1.6
"""Log likelihood that makes a pose e times as likely: so much for each pixel, as whole surfaces are
off, and for each side of a square of as many pixels, as outlines are."""
MOST_LACKING = 7.0
"""Most that the lack of an object speaks against a pose."""
APART_CELLS, APART_RAD = 1.0, 0.1
"""Distance or turn from which on another pose is another place; nearer ones are an uncertainty."""


def per_e(num_px: float) -> float:
    """Log likelihood of so many pixels that makes a pose e times as likely."""
    return math.hypot(PER_E * num_px, OUTLINE_PER_E * math.sqrt(num_px))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Odds:
    """Log odds of poses of an image."""

    portrait: Portrait
    look: Look

    def between(self, one: Array, others: Sequence[Array], paint: Paint, block: int) -> Array:
        """Log odds (N,) of a pose against others, by blocks of pixels."""
        solids = self.portrait.solids
        drawn, here = self.look.densities(solids, paint, one, block)
        things, found = self._things(drawn), []
        for T_world_left in others:
            drawn, there = self.look.densities(solids, paint, T_world_left, block)
            rival = self._things(drawn)
            # Objects that only the other pose shows have numbers of their own: below 0.
            both = np.where(things > 0, things, -rival)
            found.append(log_odds(both.ravel(), (here - there).ravel(), block))
        return np.array(found)

    def best_first(self, found: Sequence[Standpoint]) -> tuple[list[Standpoint], float]:
        """Poses with the one first that is likelier than each other, and its probability."""
        poses = [one.T_world_left for one in found]
        odds = np.array([self.between(one, poses, self.portrait.paint, 1) for one in poses])
        first = int(odds.min(axis=1).argmax())
        length = APART_CELLS * self.portrait.cell_size
        rivals = [
            -odds[first, row]
            for row, one in enumerate(found)
            if one.is_apart(found[first], length, APART_RAD)
        ]
        order = [found[first], *(one for row, one in enumerate(found) if row != first)]
        return order, float(math.exp(-logsumexp([0.0, *rivals])))

    def _things(self, drawn: Drawn) -> Indices:
        """Number from 1 on of the object (R, C) that a pixel shows, or one beside it; else 0."""
        numbers = np.append(self.portrait.thing + 1, 0)[drawn.solid]
        wider = cv2.dilate(numbers.astype(np.float32), np.ones((3, 3), np.uint8))
        found: Indices = np.where(numbers > 0, numbers, wider).astype(np.int64)
        return found


def log_odds(things: Indices, off: Array, block: int) -> float:
    """Sum of log odds of objects, from what each pixel speaks for.

    An object (below 0) that the other pose shows and the image does not may be hidden or too far
    away to be seen: its lack speaks against that pose up to a limit.
    """
    first = things.min(initial=0)
    number = block**2 * np.bincount(things - first, off != 0.0)
    total = np.bincount(things - first, off)
    odds = total / np.maximum([per_e(one) for one in number], 1.0)
    odds[:-first] = np.minimum(odds[:-first], MOST_LACKING)
    return float(odds.sum())
