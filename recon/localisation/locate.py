"""The pose of a pair in a known map, from an approximate guess."""

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
"""Standard deviations of a guess without a covariance: about the convergence range of the
registration."""
MAX_SIGMA_CELLS = 5.0
"""Points with a larger sigma do not contribute to a surface."""
MIN_POINTS = 30
MAX_PULL = 5.0
"""Maximum distance of an accepted answer from the guess, in standard deviations of the guess."""
MAX_RESIDUAL = 3.0


def locate(
    pair: StereoPair,
    voxel_map: VoxelMap | Voxels,
    guess: Array | PoseEstimate,
    settings: Settings | None = None,
) -> PoseEstimate | FitFailure:
    """Find the pose of a pair in a known map, near a guess.

    The pair's points are registered to the surface of the map's cells. Directions that they do not
    determine keep the uncertainty of the guess, so the covariance shows what is known.

    Parameters
    ----------
    pair : StereoPair
        Its own pose is ignored.
    voxel_map : VoxelMap or Voxels
    guess : (4, 4) array or PoseEstimate
        `T_world_left`, correct to about one and a half cells and 5 degrees; an estimate has its own
        covariance.
    settings : Settings, optional
        Settings of the map and of the matching of the pair.

    Returns
    -------
    PoseEstimate or FitFailure
        A failure is falsy and has the reason why the pose cannot be determined.
    """
    check_type("pair", pair, StereoPair)
    check_type("map", voxel_map, VoxelMap, Voxels)
    chosen = Settings() if settings is None else settings
    prior = prior_of(guess, voxel_map.cell_size)
    voxels = voxel_map if isinstance(voxel_map, Voxels) else occupied(voxel_map, chosen.map)
    cloud = match_points(replace(pair, T_world_left=np.eye(4)), chosen).cloud
    return locate_points(points_of(cloud, pair.rig, voxels.cell_size), Surfels.of(voxels), prior)


def prior_of(guess: Array | PoseEstimate, cell_size: float) -> Prior:
    """The guess and its information; `InputError` if it is not a pose."""
    if isinstance(guess, PoseEstimate):
        return Prior(T_world_left=guess.T_world_left, information=inverse(guess.covariance))
    check_rigid("guess", guess)
    sigma = np.repeat([np.radians(GUESS_SIGMA_DEG), GUESS_SIGMA_CELLS * cell_size], 3)
    return Prior(T_world_left=np.asarray(guess, dtype=np.float64), information=np.diag(sigma**-2.0))


def points_of(cloud: PointCloud, rig: StereoRig, cell_size: float) -> Points:
    """The points (left frame) that can be registered to a map with this cell size."""
    points = all_points(cloud, rig)
    return points.select(points.sigma <= MAX_SIGMA_CELLS * cell_size)


def all_points(cloud: PointCloud, rig: StereoRig) -> Points:
    """The points (left frame) with their uncertainties, far ones included."""
    if cloud.sigma is None:
        raise InputError("the points have no sigma, but one is needed")
    across = ACROSS_PX / rig.focal_px * cloud.points[:, 2]
    return Points(points_left=cloud.points, sigma=cloud.sigma, across=across)


def locate_points(points: Points, surfels: Surfels, prior: Prior) -> PoseEstimate | FitFailure:
    """The pose of a pair from its points and the surfels of a map."""
    if len(points) < MIN_POINTS:
        return FitFailure(f"{len(points)} points, but {MIN_POINTS} are needed")
    if not len(surfels):
        return FitFailure("the map is empty")
    found = register(points, surfels, prior)
    if found is None:
        return FitFailure("too few points are on the map")
    estimate = estimate_of(found, points, prior)
    pull = prior.pull(found.T_world_left)
    if pull @ prior.information @ pull > MAX_PULL**2:
        return FitFailure("the best match is too far from the guess")
    if estimate.residual > MAX_RESIDUAL:
        return FitFailure(f"the points are {estimate.residual:.1f} sigma off the map")
    return estimate


def estimate_of(found: Registration, points: Points, prior: Prior) -> PoseEstimate:
    """The estimate of a registered pose; its covariance includes the prior."""
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
