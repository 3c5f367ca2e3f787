"""Sights: single images with their features, and the features that two of them share."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.records import StereoPair
from recon.sequences.odometry.places import blobs, summary_of
from recon.sequences.pair_images import grey

NUM_POINTS = 600
MAX_RATIO = 0.9
"""Greatest distance of matching descriptors, as a share of that of the second nearest."""
WIDE = 0.5
"""A right image shows other sides if it is as far from the left one as this share of the distance
between neighbouring pairs."""

Rows = NDArray[np.intp]


@dataclass(frozen=True, kw_only=True, eq=False)
class Sight:
    """The features of one image."""

    number: int
    """Of its pair."""
    T_world_camera: Array
    """(4, 4); the identity if it is not known."""
    K: Array
    """(3, 3)"""
    points_px: Array
    """(N, 2)"""
    descriptors: NDArray[np.uint8]
    """(N, 128)"""

    def __len__(self) -> int:
        return len(self.points_px)

    @property
    def eye(self) -> Array:
        """(3,) position of the camera."""
        eye: Array = self.T_world_camera[:3, 3]
        return eye

    @property
    def ahead(self) -> Array:
        """(3,) direction in which it looks."""
        ahead: Array = self.T_world_camera[:3, 2]
        return ahead

    @property
    def focal_px(self) -> float:
        """Focal length."""
        return float(self.K[0, 0])

    @property
    def directions(self) -> Array:
        """(N, 3) from the camera to its points, of length 1, world."""
        rays = np.column_stack(
            [(self.points_px - self.K[:2, 2]) / self.focal_px, np.ones(len(self))]
        )
        rays = rays @ self.T_world_camera[:3, :3].T
        directions: Array = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        return directions

    @cached_property
    def summary(self) -> Array:
        """(W,) similar for images that look similar."""
        return summary_of(self.descriptors)

    @cached_property
    def rooted(self) -> NDArray[np.float32]:
        """(N, 128) descriptors whose distances are those of histograms, of length 1."""
        total = np.maximum(self.descriptors.sum(axis=1, keepdims=True), 1.0)
        rooted: NDArray[np.float32] = np.sqrt(self.descriptors / total).astype(np.float32)
        return rooted


def sight_of(pair: StereoPair, number: int = 0) -> Sight:
    """The left image of a pair."""
    T_world_left = np.eye(4) if pair.T_world_left is None else pair.T_world_left
    return _seen(pair.left, number, pair.rig.K_left, T_world_left)


def sights_of(pairs: Sequence[StereoPair]) -> list[Sight]:
    """The left images of pairs with poses, and the right ones if they show other sides."""
    found = [sight_of(pair, number) for number, pair in enumerate(pairs)]
    if _are_wide(pairs):
        found += [_right(pair, number) for number, pair in enumerate(pairs)]
    return found


def _right(pair: StereoPair, number: int) -> Sight:
    assert pair.T_world_left is not None
    K = pair.rig.K_left
    K[0, 2] = pair.rig.cx_right_px
    return _seen(pair.right, number, K, pair.T_world_left @ pair.rig.T_left_right)


def _seen(image: NDArray[np.uint8], number: int, K: Array, T_world_camera: Array) -> Sight:
    points, descriptors = blobs(grey(image), number=NUM_POINTS)
    return Sight(
        number=number, T_world_camera=T_world_camera, K=K,
        points_px=points.astype(np.float64), descriptors=descriptors,
    )  # fmt: skip


def _are_wide(pairs: Sequence[StereoPair]) -> bool:
    """True if the two cameras are about as far apart as neighbouring pairs."""
    eyes = np.array([one.T_world_left[:3, 3] for one in pairs if one.T_world_left is not None])
    apart = np.linalg.norm(eyes[:, None] - eyes, axis=2)
    apart[apart == 0.0] = np.inf
    baseline = float(np.median([pair.rig.baseline for pair in pairs]))
    return bool(baseline > WIDE * np.median(apart.min(axis=1)))


def matched(one: NDArray[np.float32], other: NDArray[np.float32]) -> tuple[Rows, Rows]:
    """Rows (M,) of descriptors, of length 1, that are nearest to each other, and clearly so."""
    if len(one) < 2 or len(other) < 2:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    likeness = one @ other.T
    there, back = likeness.argmax(axis=1), likeness.argmax(axis=0)
    row = np.arange(len(one))
    best = likeness[row, there]
    likeness[row, there] = -1.0
    second = likeness.max(axis=1)
    # Squared distances are 2 - 2 cosines.
    clear = (1.0 - best) < MAX_RATIO**2 * (1.0 - second)
    kept = np.flatnonzero(clear & (back[there] == row))
    return kept, there[kept]
