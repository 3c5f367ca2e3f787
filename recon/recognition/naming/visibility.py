"""What of an object is seen, and what must be there although it is not."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.composite import Stack, StackModel
from recon.records import Voxels

UNSEEN = 0.1
"""A part is unseen that has less of its surface in cells than this share of the best seen one."""
HOVERING = 0.15
"""Share of its height that an object's lowest cell may be over the ground: what hovers higher is
held by something that is not seen."""
TRUNK = 0.3
"""Radius of a body that is not seen, as a share of its crown's."""


def is_hovering(cells: Voxels, ground: float) -> bool:
    """Whether no cell is near the ground."""
    low, high = cells.means[:, 1].min(), cells.means[:, 1].max()
    return bool(low - ground > HOVERING * (high - ground) + 2.0 * cells.cell_size)


def unseen_parts(stack: Stack, cells: Voxels) -> NDArray[np.bool_]:
    """(parts,) which parts have next to no cells for their surface."""
    _, _, nearest = StackModel(cells.means).nearest(stack)
    counts = np.bincount(nearest, minlength=len(stack.shapes))
    density = counts / np.maximum(stack.areas, cells.cell_size**2)
    unseen: NDArray[np.bool_] = density < UNSEEN * density.max()
    return unseen


def with_thin_body(stack: Stack, cells: Voxels) -> Stack:
    """The stack, its lowest part no wider than a trunk where it is not seen."""
    if not unseen_parts(stack, cells)[0] or not len(stack.radii[0]):
        return stack
    radius = np.minimum(stack.radii[0], TRUNK * stack.widest[1:].max(initial=0.0))
    return replace(stack, radii=(radius, *stack.radii[1:]))
