"""The straight line: two images -> pairs of features -> coloured world points -> the voxel map."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_type
from recon.geometry import LEVEL_CAMERA
from recon.records import Features, Matches, PointCloud, StereoPair, check_images
from recon.settings import QUALITIES, Quality, Settings, updated, with_quality
from recon.stereo.features import detect
from recon.stereo.matching.matching import match, match_whole_images
from recon.stereo.subpixel import refine
from recon.stereo.triangulation import triangulate
from recon.voxelmap import VoxelMap


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PairResult:
    """What one pair gave."""

    matches: Matches
    cloud: PointCloud
    """In the world; in the left camera's frame where the pair has no pose."""

    def __repr__(self) -> str:
        return f"PairResult({len(self.matches)} matches, {len(self.cloud)} points)"


def match_pair(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    *,
    min_disparity: int = 0,
    max_disparity: int = 20,
    quality: Quality = "best",
) -> Matches:
    """Match two rectified images.

    Parameters
    ----------
    left, right : (H, W) or (H, W, 3) uint8
        Grey or RGB, of one size.
    min_disparity, max_disparity : int
        Both ends of the search, included.
    quality : {"best", "fast"}

    Returns
    -------
    Matches
        Most confident first.
    """
    if quality not in QUALITIES:
        raise InputError(f"quality is {quality!r}, but one of {', '.join(QUALITIES)} is needed")
    check_images(left, right)
    for name, value in (("min_disparity", min_disparity), ("max_disparity", max_disparity)):
        check_type(name, value, int, np.integer)
    search = {"min_disparity": min_disparity, "max_disparity": max_disparity}
    return match_images(
        left, right, updated(with_quality(Settings(), quality), {"matching": search})
    )


def match_images(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    settings: Settings,
    stated_range: tuple[int, int] | None = None,
) -> Matches:
    """Match two rectified images as the settings say.

    Parameters
    ----------
    stated_range : (min, max), optional
        Search range in pixels that holds where the settings were not given one.
    """
    search = settings.matching.searching(stated_range)
    whole = match_whole_images(left, right, search)
    if whole is not None:
        return whole
    # Oriented features of both images at several scales (Eqs 11 to 14).
    features_left = detect(left, settings.features)
    features_right = detect(right, settings.features)
    return match_features(features_left, features_right, settings, stated_range)


def match_features(
    features_left: Features,
    features_right: Features,
    settings: Settings,
    stated_range: tuple[int, int] | None = None,
) -> Matches:
    """Match the features of two rectified images, to fractions of a pixel."""
    # Pairs of like phase and magnitude, cross checked (Eqs 15 to 18).
    matches = match(features_left, features_right, settings.matching.searching(stated_range))
    # Refined by the phase that is left (Eqs 20, 21).
    return refine(matches, features_left, features_right)


def process_pair(
    pair: StereoPair, settings: Settings, voxel_map: VoxelMap, view: int | None = None
) -> PairResult:
    """One pair into the map.

    All points with a depth are returned, so that far things are seen; the map takes only those
    that are sure enough for its cells. The search range is the one that the settings were given,
    else what the pair states.

    Parameters
    ----------
    view : int, optional
        Number of the pair; needed by a map that keeps views.
    """
    check_type("pair", pair, StereoPair)
    check_type("settings", settings, Settings)
    check_type("voxel_map", voxel_map, VoxelMap)
    result = match_points(pair, settings)
    insert(result.cloud, pair, settings, voxel_map, view)
    return result


def match_points(pair: StereoPair, settings: Settings) -> PairResult:
    """The matches of a pair and their points in the world.

    A pair without a pose is level at the world's origin, so that y is up there too.
    """
    matches = match_images(pair.left, pair.right, settings, pair.disparity_range)
    # Depth and its uncertainty (Eqs 19, 44), brought into the world (Eq 45).
    cloud = triangulate(matches, pair, settings.triangulation)
    T_world_left = LEVEL_CAMERA if pair.T_world_left is None else pair.T_world_left
    return PairResult(matches=matches, cloud=cloud.transformed(T_world_left))


def insert(
    cloud: PointCloud,
    pair: StereoPair,
    settings: Settings,
    voxel_map: VoxelMap,
    view: int | None = None,
) -> None:
    """Count every point that is sure enough in its cell (section 4.4)."""
    origin = None if pair.T_world_left is None else pair.T_world_left[:3, 3]
    if settings.map.max_sigma is not None and cloud.sigma is not None:
        cloud = cloud.select(cloud.sigma <= settings.map.max_sigma * settings.map.cell_size)
    voxel_map.insert(cloud, origin, view)
