"""Links of a walk: steps between planar poses, as they were meant or measured."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.geometry import wrapped
from recon.localisation.blocks import Block

Array = NDArray[np.float64]

ROBUST = 3.0
"""Standard deviations from which Cauchy weights reduce the influence of a residual."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Link:
    """A measurement of the motion from one pose to another."""

    first: int
    second: int
    step: Array
    """(3,) shift forwards and sideways in the frame of the first pose, and rotation."""
    information: Array
    """(3, 3) of the step."""
    is_sure: bool = False
    """True for a step, which cannot be a false match."""


def led_by(poses: Array, steps: Array) -> Array:
    """Change (N, 3) of planar poses (N, 3) by steps (N, 3) forwards, sideways and around."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    ahead, aside, turn = steps.T
    return np.column_stack([c * ahead - s * aside, s * ahead + c * aside, turn])


def steps_between(before: Array, after: Array) -> Array:
    """Steps (N, 3) forwards, sideways and around between planar poses (N, 3)."""
    c, s = np.cos(before[:, 2]), np.sin(before[:, 2])
    x, z, turn = (after - before).T
    return np.column_stack([c * x + s * z, -s * x + c * z, wrapped(turn)])


def step_between(before: Array, after: Array) -> Array:
    """Step (3,) forwards, sideways and around from one planar pose to another."""
    step: Array = steps_between(before[None], after[None])[0]
    return step


def step_derivatives(before: Array, after: Array) -> Array:
    """Derivatives (N, 3, 6) of the steps between planar poses by both."""
    step, one, zero = steps_between(before, after), np.ones(len(before)), np.zeros(len(before))
    c, s = np.cos(before[:, 2]), np.sin(before[:, 2])
    rows = [
        [-c, -s, step[:, 1], c, s, zero],
        [s, -c, -step[:, 0], -s, c, zero],
        [zero, zero, -one, zero, zero, one],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def links_block(links: Sequence[Link], poses: Array) -> Block:
    """The equations of links between poses (N, 3)."""
    rows = np.array([(link.first, link.second) for link in links], np.intp).reshape(-1, 2)
    first, second = poses[rows[:, 0]], poses[rows[:, 1]]
    off = steps_between(first, second) - np.array([link.step for link in links]).reshape(-1, 3)
    off[:, 2] = wrapped(off[:, 2])
    information = np.array([link.information for link in links]).reshape(-1, 3, 3)
    root = np.linalg.cholesky(information).swapaxes(1, 2)
    residual = np.einsum("nij,nj->ni", root, off)
    # A link between two pairs that do not show the same has a large error.
    off_sq = np.where([link.is_sure for link in links], 0.0, (residual**2).sum(axis=1))
    weight = 1.0 / np.sqrt(1.0 + off_sq / ROBUST**2)
    derivative = root @ step_derivatives(first, second) * weight[:, None, None]
    columns = 3 * rows[:, [0, 0, 0, 1, 1, 1]] + np.tile(np.arange(3), 2)
    return Block.of(
        (residual * weight[:, None]).ravel(), derivative.reshape(-1, 6), columns.repeat(3, axis=0)
    )
