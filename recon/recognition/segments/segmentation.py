"""Segmentation of an object into parts by colour."""

import numpy as np
from numpy.typing import NDArray

from recon.geometry import hue_distance_deg
from recon.recognition.adjacency import neighbours
from recon.recognition.colour import is_vivid, rgb_to_hsv
from recon.recognition.connectivity import joined
from recon.records import FitFailure, Segments, Voxels

Array = NDArray[np.float64]

MAJORITY_ROUNDS = 3
MIN_HUE_DIFFERENCE_DEG = 15.0
"""Two parts whose hues differ by less cannot be distinguished by colour."""
MIN_SEPARATION = 2.0
"""Minimum distance of two separate colour clusters, in their own spreads."""


def grow_hue(voxels: Voxels, tolerance_deg: float) -> Segments:
    """The thesis's segmentation: neighbours of similar hue grow together (4.5).

    A cell joins any of its 26 neighbours whose hue is less than `tolerance_deg` away, around the
    circle; grey cells, which have no hue, join grey ones. Parts are numbered by descending size.
    """
    pairs = neighbours(voxels.index)
    hue = rgb_to_hsv(voxels.shown_colours)[:, 0]
    first, second = hue[pairs].T
    alike = hue_distance_deg(first, second) < tolerance_deg
    both, one = (first < 0) & (second < 0), (first < 0) ^ (second < 0)
    label = joined(pairs[both | (alike & ~one)], len(voxels))
    sizes = np.bincount(label)
    rank = np.argsort(np.argsort(-sizes, kind="stable"))
    return Segments(label=rank[label].astype(np.int32) if len(label) else label)


def split_colours(voxels: Voxels) -> Segments | FitFailure:
    """Two parts, 0 below and 1 above, by chroma clusters and the majority of neighbours.

    Chroma is the log ratio of the colour channels, in which shading cancels. The clusters start
    from the lowest and the highest quarter; cells of mixed or grey colour follow their neighbours.
    """
    chroma = _log_chroma(voxels.shown_colours)
    upper = _two_means(chroma, voxels.means[:, 1])
    if isinstance(upper, FitFailure):
        return upper
    pairs = neighbours(voxels.index)
    for _ in range(MAJORITY_ROUNDS):
        upper = _majority(upper, pairs)
    fault = _not_apart(chroma, voxels.shown_colours, upper)
    return FitFailure(fault) if fault else Segments(label=upper.astype(np.int32))


def _log_chroma(colours: NDArray[np.uint8]) -> Array:
    red, green, blue = np.log(colours.astype(np.float64) + 8.0).T
    return np.column_stack([red - green, green - blue])


def _two_means(chroma: Array, height: Array) -> NDArray[np.bool_] | FitFailure:
    low, high = np.quantile(height, [0.25, 0.75])
    centres = np.stack(
        [np.median(chroma[rows], axis=0) for rows in (height <= low, height >= high)]
    )
    upper = np.zeros(len(chroma), dtype=bool)
    for _ in range(20):
        distance = np.linalg.norm(chroma[:, None] - centres, axis=2)
        before, upper = upper, distance[:, 1] < distance[:, 0]
        if upper.all() or not upper.any():
            return FitFailure("all cells have one colour")
        if (upper == before).all():
            break
        centres = np.stack([np.median(chroma[rows], axis=0) for rows in (~upper, upper)])
    return upper


def _majority(upper: NDArray[np.bool_], pairs: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Majority vote of each cell and its neighbours."""
    sign = np.where(upper, 1.0, -1.0)
    votes = sign.copy()
    np.add.at(votes, pairs[:, 0], sign[pairs[:, 1]])
    np.add.at(votes, pairs[:, 1], sign[pairs[:, 0]])
    return np.where(votes == 0, upper, votes > 0)


def _not_apart(chroma: Array, colours: NDArray[np.uint8], upper: NDArray[np.bool_]) -> str:
    """The reason why the two parts do not have two colours; empty if they do."""
    if upper.all() or not upper.any():
        return "all cells have one colour"
    groups = [chroma[~upper], chroma[upper]]
    middles = [np.median(group, axis=0) for group in groups]
    spread = max(float(np.median(np.abs(g - m))) for g, m in zip(groups, middles, strict=True))
    if np.linalg.norm(middles[1] - middles[0]) < MIN_SEPARATION * 1.4826 * spread:
        return "the colours of the parts run into each other"
    below, above = (
        rgb_to_hsv(np.median(colours[rows], axis=0)[None].astype(np.uint8))
        for rows in (~upper, upper)
    )
    both_vivid = is_vivid(below)[0] and is_vivid(above)[0]
    if both_vivid and hue_distance_deg(below[0, 0], above[0, 0]) < MIN_HUE_DIFFERENCE_DEG:
        return "the parts have one hue"
    return ""
