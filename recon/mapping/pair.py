"""The pipeline of one pair: images -> matches -> coloured world points -> the voxel map."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError, check_number, check_type
from recon.geometry import LEVEL_CAMERA
from recon.mapping.sparse import match_sparse
from recon.records import Matches, PointCloud, StereoPair, check_images
from recon.settings import QUALITIES, Quality, Settings, updated, with_quality
from recon.stereo.dense.dense import as_matches, match_every_pixel
from recon.stereo.triangulation import triangulate
from recon.voxelmap import VoxelMap


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PairResult:
    """Matches and points of one pair."""

    matches: Matches
    cloud: PointCloud
    """Precise points, in the world."""
    doubtful: PointCloud
    """Points of improbable matches and of edges along the row, in the world."""
    image_noise: tuple[float, float]
    """Standard deviation of the noise of the left and the right image, grey levels."""

    def __repr__(self) -> str:
        return f"PairResult({len(self.matches)} matches, {len(self.cloud)} points)"

    def transformed(self, T_target_source: ArrayLike) -> "PairResult":
        """The same result with its points in the target frame."""
        return replace(
            self,
            cloud=self.cloud.transformed(T_target_source),
            doubtful=self.doubtful.transformed(T_target_source),
        )


def match_pair(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    min_disparity: int = 0,
    max_disparity: int = 20,
    quality: Quality = "best",
    *,
    residual_px: float | None = None,
) -> Matches:
    """Match two rectified images.

    Parameters
    ----------
    left, right : (H, W) or (H, W, 3) uint8
        Grey or RGB, of the same size.
    min_disparity, max_disparity : int
        Both ends of the search range, included.
    quality : {"best", "fast"}
    residual_px : float, optional
        Root mean square error of disparities due to the calibration, 0 if it is exact (see
        `StereoRig.residual_px`); None = as the rows of the images suggest.

    Returns
    -------
    Matches
        Most confident first.
    """
    if quality not in QUALITIES:
        raise InputError(f"quality is {quality!r}, but one of {', '.join(QUALITIES)} is needed")
    check_images(left, right)
    for name, value in (("min_disparity", min_disparity), ("max_disparity", max_disparity)):
        if not isinstance(value, int | np.integer):
            raise InputError(f"{name} is {value!r}, but a whole number is needed")
    if residual_px is not None:
        check_number("residual_px", residual_px, low=0)
    search = {"min_disparity": min_disparity, "max_disparity": max_disparity}
    settings = updated(with_quality(Settings(), quality), {"matching": search})
    return match_sparse(left, right, settings, residual_px=residual_px).matches


def process_pair(
    pair: StereoPair, settings: Settings, voxel_map: VoxelMap, view: int | None = None
) -> PairResult:
    """Match one pair and insert its points into the map.

    All points with a depth are returned, so that far objects are seen; the map counts precise ones
    in its cells, the others in coarser ones. The search range is that of the settings, else the one
    that the pair states.

    Parameters
    ----------
    view : int, optional
        Number of the pair; needed by a map that keeps views.
    """
    check_type("pair", pair, StereoPair)
    check_type("settings", settings, Settings)
    check_type("voxel_map", voxel_map, VoxelMap)
    result = match_points(pair, settings)
    insert(result.cloud, result.doubtful, pair, settings, voxel_map, view)
    return result


def _matches_for_map(matches: Matches, pair: StereoPair, settings: Settings) -> Matches:
    """Matches for the map: the sparse ones, or one per pixel if the settings say so."""
    if settings.map.points == "sparse":
        return matches
    found = match_every_pixel(pair.left, pair.right, settings, pair.disparity_range)
    return as_matches(found)


def match_points(pair: StereoPair, settings: Settings) -> PairResult:
    """The matches of a pair and their points in the world.

    A pair without a pose is placed level at the world's origin, so that y is up.
    """
    found = match_sparse(
        pair.left, pair.right, settings, pair.disparity_range, pair.rig.residual_px
    )
    # Depth and its uncertainty (Eqs 19, 44), transformed to the world (Eq 45).
    points = triangulate(
        _matches_for_map(found.matches, pair, settings), pair, settings.triangulation
    )
    points = points.transformed(LEVEL_CAMERA if pair.T_world_left is None else pair.T_world_left)
    return PairResult(
        matches=found.matches,
        cloud=points.sure,
        doubtful=points.doubtful,
        image_noise=found.image_noise,
    )


def insert(
    cloud: PointCloud,
    doubtful: PointCloud,
    pair: StereoPair,
    settings: Settings,
    voxel_map: VoxelMap,
    view: int | None = None,
) -> int:
    """Count every precise point in its cell (section 4.4), all others in coarser cells.

    Returns
    -------
    int
        Number of points counted.
    """
    origin = None if pair.T_world_left is None else pair.T_world_left[:3, 3]
    num_counted = count_points(cloud, origin, settings, voxel_map, view)
    return num_counted + voxel_map.insert_doubtful(doubtful)


def count_points(
    cloud: PointCloud,
    origin: NDArray[np.float64] | None,
    settings: Settings,
    voxel_map: VoxelMap,
    view: int | None = None,
) -> int:
    """Count points (world), seen from an origin, in fine or coarse cells; return their number."""
    fits = np.ones(len(cloud), np.bool_)
    if settings.map.max_sigma is not None and cloud.sigma is not None:
        fits = cloud.sigma <= settings.map.max_sigma * settings.map.cell_size
    voxel_map.insert(cloud.select(fits), origin, view)
    return int(fits.sum()) + voxel_map.insert_doubtful(cloud.select(~fits))
