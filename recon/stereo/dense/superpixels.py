"""Superpixels: small patches of like colour, over each of which disparity is one plane."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from skimage.segmentation import slic

from recon.stereo.kernels.simd import Integers

Array = NDArray[np.float64]

_COMPACTNESS = 12.0
"""How much a superpixel keeps together rather than following the colours."""
_MOST_NEIGHBOURS = 8
"""Neighbours that are listed of each, those with the longest border first."""


class Superpixels(NamedTuple):
    """An image cut into S patches."""

    label: Integers
    """(H, W) patch of each pixel."""
    centres_px: Array
    """(S, 2) mean u, v."""
    sizes: Integers
    """(S,) number of pixels."""
    neighbours: Integers
    """(S, N) patches that touch; -1 = there are no more."""


def cut(image: NDArray[np.uint8], side_px: float) -> Superpixels:
    """Cut an image (H, W) or (H, W, 3) into superpixels of about some side."""
    height, width = image.shape[:2]
    label = np.asarray(
        slic(
            image,
            n_segments=max(1, round(height * width / side_px**2)),
            compactness=_COMPACTNESS if image.ndim == 3 else _COMPACTNESS / 100,
            start_label=0,
            channel_axis=-1 if image.ndim == 3 else None,
        )
    )
    sizes = np.bincount(label.ravel())
    v, u = np.indices(label.shape)
    sums = [np.bincount(label.ravel(), weights=x.ravel()) for x in (u, v)]
    centres = np.column_stack(sums) / np.maximum(sizes, 1)[:, None]
    return Superpixels(label, centres, sizes, _neighbours(label, len(sizes)))


def _neighbours(label: Integers, count: int) -> Integers:
    """(S, N) patches that touch, the longest borders first."""
    across = [(label[:, :-1], label[:, 1:]), (label[:-1], label[1:])]
    borders = np.concatenate([a[a != b] * count + b[a != b] for a, b in across])
    a, b = np.divmod(borders, count)
    border, length = np.unique(np.concatenate([borders, b * count + a]), return_counts=True)
    a, b = np.divmod(border, count)
    along = np.lexsort((-length, a))
    a, b = a[along], b[along]
    rank = np.arange(len(a)) - np.searchsorted(a, a)
    listed = np.full((count, _MOST_NEIGHBOURS), -1)
    near = rank < _MOST_NEIGHBOURS
    listed[a[near], rank[near]] = b[near]
    return listed
