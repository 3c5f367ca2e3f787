"""A small histogram of hue in each cell."""

import numpy as np
from numpy.typing import NDArray

from recon.voxelmap.channels import Columns, RowSums, Scan


class Hues(RowSums):
    """Points by hue, as the mean of opposite hues is grey and of reds may be cyan."""

    name = "hue"
    NUM_BINS = 12
    width = NUM_BINS + 1
    # Below these the hue of a pixel is noise.
    MIN_SATURATION = 0.15
    MIN_VALUE = 0.1

    def amounts(self, scan: Scan) -> NDArray[np.uint64]:
        """One in the bin of each point's hue, the last being grey (N, 13)."""
        return np.eye(self.width, dtype=np.uint64)[self.bins(scan.cloud.shown_colours)]

    def fields(self, order: NDArray[np.int64], index: NDArray[np.int64]) -> Columns:
        """`Voxels.hues`."""
        return {"hues": self.of(order).astype(np.int64)}

    @classmethod
    def bins(cls, colours: NDArray[np.uint8]) -> NDArray[np.int64]:
        """The bin (N,) of RGB colours (N, 3); bin 0 begins at red."""
        red, green, blue = colours.T.astype(np.float64) / 255.0
        value, low = colours.max(axis=1) / 255.0, colours.min(axis=1) / 255.0
        chroma = np.maximum(value - low, 1e-9)
        sextant = np.select(
            [value == red, value == green],
            [(green - blue) / chroma, 2.0 + (blue - red) / chroma],
            4.0 + (red - green) / chroma,
        )
        bins = np.floor(np.mod(sextant, 6.0) * cls.NUM_BINS / 6.0).astype(np.int64)
        is_grey = (value < cls.MIN_VALUE) | (value - low < cls.MIN_SATURATION * value)
        return np.where(is_grey, cls.NUM_BINS, np.minimum(bins, cls.NUM_BINS - 1))


def dominant_hue_deg(hues: NDArray[np.int64]) -> NDArray[np.float64]:
    """The hue (K,) of histograms (K, 13), NaN where most points are grey.

    The mean of the fullest bin and its two neighbours: a few points of another hue, as of the sky
    at an outline, do not move it.
    """
    coloured = hues[:, : Hues.NUM_BINS]
    near = np.argmax(coloured, axis=1)[:, None] + np.array([-1, 0, 1])
    counts = np.take_along_axis(coloured, near % Hues.NUM_BINS, axis=1)
    total = counts.sum(axis=1)
    bin_deg = 360.0 / Hues.NUM_BINS
    mean = (counts * (near + 0.5)).sum(axis=1) * bin_deg / np.maximum(total, 1)
    is_grey = hues[:, Hues.NUM_BINS] >= np.maximum(coloured.sum(axis=1), 1)
    return np.where(is_grey, np.nan, np.mod(mean, 360.0))
