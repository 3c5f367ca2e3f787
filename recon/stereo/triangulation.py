"""From pairs to coloured points in the frame of the left camera (thesis 3.5, Eq 19)."""

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.records import Matches, PointCloud, StereoPair
from recon.settings import TriangulationSettings
from recon.stereo.uncertainty import UNTUNED_SIGMA_PX


def triangulate(matches: Matches, pair: StereoPair, settings: TriangulationSettings) -> PointCloud:
    """Coloured points of the pairs that meet in front of the eyes.

    Parameters
    ----------
    matches : Matches
    pair : StereoPair
        Gives the colours and the rig.
    settings : TriangulationSettings

    Returns
    -------
    PointCloud
        In the LEFT camera's frame, in the order of the matches, each with the standard deviation
        of its depth; pairs without a depth, or with a less sure one than `max_sigma`, are left out,
        and so are those that could not be tuned: an edge along the row, as the horizon is, fits
        everywhere on it.
    """
    points = pair.rig.triangulate(matches.points_px, matches.disparity_px)
    sigma = pair.rig.depth_sigma(points[:, 2], matches.sigma_px)
    cloud = PointCloud(points=points, colours=_colours(matches, pair.left, settings), sigma=sigma)
    limit = np.inf if settings.max_sigma is None else settings.max_sigma
    is_tuned = matches.sigma_px < UNTUNED_SIGMA_PX
    return cloud.select(np.isfinite(points).all(axis=1) & (sigma <= limit) & is_tuned)


def _colours(
    matches: Matches, image: NDArray[np.uint8], settings: TriangulationSettings
) -> NDArray[np.uint8]:
    """(M, 3) mean colour of the square round each point, cut off at the border."""
    rgb = image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2)
    side = (settings.colour_window_px, settings.colour_window_px)
    mean = cv2.blur(np.ascontiguousarray(rgb), side, borderType=cv2.BORDER_REPLICATE)
    u, v = np.rint(matches.points_px).astype(np.int64).T
    colours: NDArray[np.uint8] = mean[v, u]
    return colours
