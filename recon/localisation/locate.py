"""The pose of a pair in a known map, from a guess that is nearly right."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.errors import InputError, check_type
from recon.geometry import check_rigid
from recon.localisation.registration import (
    ACROSS_PX,
    Points,
    Prior,
    Registration,
    inverse,
    register,
)
from recon.localisation.surfels import Surfels
from recon.mapping.pair import match_points
from recon.records import FitFailure, PointCloud, PoseEstimate, StereoPair, Voxels
from recon.settings import Settings
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import occupied

Array = NDArray[np.float64]

GUESS_SIGMA_CELLS, GUESS_SIGMA_DEG = 1.5, 5.0
"""Of a guess without a covariance: about as far as registration finds its way back from."""
MAX_SIGMA_CELLS = 5.0
"""Points that are less sure tell nothing of a surface."""
MIN_POINTS = 30
MAX_PULL = 5.0
"""Standard deviations of the guess between it and an answer that is believed."""
MAX_RESIDUAL = 3.0


def locate(
    pair: StereoPair,
    voxel_map: VoxelMap | Voxels,
    guess: Array | PoseEstimate,
    settings: Settings | None = None,
) -> PoseEstimate | FitFailure:
    """Find the pose of a pair in a known map, near a guess.

    The pair's points are laid on the surface that the cells of the map make. Directions that they
    do not tell keep the uncertainty of the guess, so that the covariance says what is known.

    Parameters
    ----------
    pair : StereoPair
        Its own pose is not looked at.
    voxel_map : VoxelMap or Voxels
    guess : (4, 4) array or PoseEstimate
        `T_world_left`, right to about one and a half cells and 5 degrees; an estimate brings its
        own covariance.
    settings : Settings, optional
        Of the map, and of the matching of the pair.

    Returns
    -------
    PoseEstimate or FitFailure
        Falsy, with the reason, where the pair does not tell.
    """
    check_type("pair", pair, StereoPair)
    check_type("map", voxel_map, VoxelMap, Voxels)
    chosen = Settings() if settings is None else settings
    prior = prior_of(guess, voxel_map.cell_size)
    voxels = voxel_map if isinstance(voxel_map, Voxels) else occupied(voxel_map, chosen.map)
    cloud = match_points(replace(pair, T_world_left=np.eye(4)), chosen).cloud
    return locate_points(points_of(cloud, pair.rig, voxels.cell_size), Surfels.of(voxels), prior)


def prior_of(guess: Array | PoseEstimate, cell_size: float) -> Prior:
    """The guess and its information; `InputError` where it is not a pose."""
    if isinstance(guess, PoseEstimate):
        return Prior(T_world_left=guess.T_world_left, information=inverse(guess.covariance))
    check_rigid("guess", guess)
    sigma = np.repeat([np.radians(GUESS_SIGMA_DEG), GUESS_SIGMA_CELLS * cell_size], 3)
    return Prior(T_world_left=np.asarray(guess, dtype=np.float64), information=np.diag(sigma**-2.0))


def points_of(cloud: PointCloud, rig: StereoRig, cell_size: float) -> Points:
    """The points (left frame) that can be laid on a map of such cells."""
    if cloud.sigma is None:
        raise InputError("the points have no sigma, but one is needed")
    sure = cloud.select(cloud.sigma <= MAX_SIGMA_CELLS * cell_size)
    assert sure.sigma is not None
    across = ACROSS_PX / rig.focal_px * sure.points[:, 2]
    return Points(points_left=sure.points, sigma=sure.sigma, across=across)


def locate_points(points: Points, surfels: Surfels, prior: Prior) -> PoseEstimate | FitFailure:
    """The pose of points of a pair on the surfels of a map."""
    if len(points) < MIN_POINTS:
        return FitFailure(f"{len(points)} points, but {MIN_POINTS} are needed")
    if not len(surfels):
        return FitFailure("the map is empty")
    found = register(points, surfels, prior)
    if found is None:
        return FitFailure("too few points lie on the map")
    estimate = _estimate(found, points, prior)
    pull = prior.pull(found.T_world_left)
    if pull @ prior.information @ pull > MAX_PULL**2:
        return FitFailure("the map is met too far from the guess")
    if estimate.residual > MAX_RESIDUAL:
        return FitFailure(f"the points lie {estimate.residual:.1f} sigma off the map")
    return estimate


def _estimate(found: Registration, points: Points, prior: Prior) -> PoseEstimate:
    contacts = found.contacts
    information = found.information / max(1.0, contacts.spread**2) + prior.information
    return PoseEstimate(
        T_world_left=found.T_world_left,
        covariance=inverse(information),
        probability=contacts.num_points / max(1, contacts.num_near),
        residual=contacts.spread,
        inlier_share=contacts.num_points / len(points),
        num_cells=len(contacts.residual),
    )
