"""Triangulation of matches to coloured points in the left camera's frame (thesis 3.5, Eq 19)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from recon.records import Matches, PointCloud, StereoPair
from recon.settings import TriangulationSettings
from recon.stereo.colours import point_colours


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Triangulation:
    """Points of a pair in the LEFT camera's frame, in the order of the matches.

    Every match with a finite depth in front of the cameras is in one of the two clouds.
    """

    sure: PointCloud
    """Points of refined matches that are more likely correct than wrong."""
    doubtful: PointCloud
    """All others: improbable matches, and edges along the row, which match anywhere on it."""

    def transformed(self, T_target_source: ArrayLike) -> "Triangulation":
        """The same points in the target frame."""
        return Triangulation(
            sure=self.sure.transformed(T_target_source),
            doubtful=self.doubtful.transformed(T_target_source),
        )


def triangulate(
    matches: Matches, pair: StereoPair, settings: TriangulationSettings
) -> Triangulation:
    """Coloured points of the matches whose rays meet in front of the cameras.

    Parameters
    ----------
    matches : Matches
    pair : StereoPair
        Provides the colours and the rig.
    settings : TriangulationSettings

    Returns
    -------
    Triangulation
        Points with the standard deviation of their depth. `sure` ones are refined, have at least
        `min_probability` or an unknown probability, and a depth sigma up to `max_sigma`.
    """
    points = pair.rig.triangulate(matches.points_px, matches.disparity_px)
    sigma = pair.rig.depth_sigma(points[:, 2], matches.sigma_px)
    limit = np.inf if settings.max_sigma is None else settings.max_sigma
    is_sure = (sigma <= limit) & ~matches.is_whole
    # Written so that an unknown probability passes.
    is_sure &= ~(matches.probability < settings.min_probability)
    is_seen = np.isfinite(points).all(axis=1)
    colours = point_colours(matches, pair, is_seen & is_sure, settings.colour_window_px)
    cloud = PointCloud(points=points, colours=colours, sigma=sigma)
    return Triangulation(
        sure=cloud.select(is_seen & is_sure), doubtful=cloud.select(is_seen & ~is_sure)
    )
