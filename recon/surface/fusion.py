"""Fusion of the disparities of pairs into one surface: confirmed, fused, meshed."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import DisparityMap, Mesh, PointCloud, StereoPair
from recon.settings import SurfaceSettings
from recon.surface.cells import CellCloud
from recon.surface.closing import watertight
from recon.surface.confirmation import Confirmation
from recon.surface.depth import DepthMap, depth_map
from recon.surface.triangles import largest_share, mesh_of_pixels, without_floaters
from recon.surface.volume import Volume

_PIXELS_TO_VOXEL = 2.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surface:
    """The surface seen by the cameras, in the world."""

    cloud: PointCloud
    """With sigma, and the attribute `views`: the number of views that agree on a point."""
    mesh: Mesh | None
    """None if not requested."""
    metrics: dict[str, Any]
    """Metrics by their names in metrics.json."""


class Fusion:
    """Takes pairs with their disparities, one at a time, and returns the surface at the end.

    For a single pair, the pixels are the cloud, and the mesh joins neighbouring ones; for several,
    depths confirmed by other views are fused in voxels.
    """

    def __init__(self, settings: SurfaceSettings) -> None:
        self.settings = settings
        self.voxel = settings.voxel
        self._first: DepthMap | None = None
        self._num_pairs = 0
        self._num_pixels = self._num_known = self._num_confirmed = 0
        self._confirmation = Confirmation()
        self._volume: Volume | None = None
        self._cells: CellCloud | None = None

    def add(self, pair: StereoPair, found: DisparityMap) -> DepthMap:
        """Add the next pair, and return its unconfirmed depths.

        Raises
        ------
        InputError
            For a second pair without a pose.
        """
        if self._num_pairs and pair.T_world_left is None:
            raise InputError(
                f"{pair.name} has no pose, but surfaces of several pairs need one each: "
                "give --poses given or estimated"
            )
        view = depth_map(pair, found)
        self._num_pairs += 1
        self._num_pixels += found.disparity_px.size
        self._num_known += int(view.valid_mask.sum())
        if self._num_pairs == 1:
            self._first = view
            self.voxel = self.voxel or suggested_voxel(view)
        self._fuse(self._confirmation.add(view))
        return view

    def finish(self) -> Surface:
        """The surface of all pairs."""
        if self._num_pairs == 1 and self._first is not None:
            return self._of_one(self._first)
        self._fuse(self._confirmation.finish())
        cells = self._cells or CellCloud(1.0)
        mesh = None
        if self.settings.mesh:
            fused = without_floaters(self._volume.mesh()) if self._volume else Mesh.none()
            mesh = self._closed(replace(fused, colours=cells.colours_at(fused.vertices)))
        return self._surface(cells.cloud(), mesh, self._num_confirmed / max(self._num_known, 1))

    def _fuse(self, views: Iterable[DepthMap]) -> None:
        for view in views:
            self._num_confirmed += int(view.valid_mask.sum())
            if self._num_pairs == 1 or self.voxel is None:
                continue
            self._cells = self._cells or CellCloud(self.voxel)
            self._cells.add(view)
            if self.settings.mesh:
                self._volume = self._volume or Volume(self.voxel)
                self._volume.add(view)

    def _of_one(self, view: DepthMap) -> Surface:
        mask = view.valid_mask
        cloud = PointCloud(
            points=view.points(mask),
            colours=view.colours[mask],
            sigma=view.sigma[mask].astype(np.float64),
            attributes={"views": np.ones(int(mask.sum()), np.uint8)},
        )
        mesh = None
        if self.settings.mesh:
            mesh = self._closed(without_floaters(mesh_of_pixels(view), smallest_share=1e-4))
        return self._surface(cloud, mesh, None)

    def _closed(self, mesh: Mesh) -> Mesh:
        return watertight(mesh) if self.settings.watertight and len(mesh) else mesh

    def _surface(self, cloud: PointCloud, mesh: Mesh | None, share: float | None) -> Surface:
        metrics: dict[str, Any] = {
            "num_dense_points": len(cloud),
            "dense_share": self._num_known / max(self._num_pixels, 1),
            "dense_confirmed_share": share,
        }
        if mesh is not None:
            metrics |= {
                "voxel": self.voxel,
                "num_triangles": len(mesh),
                "mesh_area": mesh.area,
                "largest_piece_share": largest_share(mesh),
            }
        return Surface(cloud=cloud, mesh=mesh, metrics=metrics)


def suggested_voxel(view: DepthMap) -> float | None:
    """Two pixels at the median depth of a view, or its median sigma if that is larger."""
    mask: NDArray[np.bool_] = view.valid_mask
    if not mask.any():
        return None
    wide = _PIXELS_TO_VOXEL * float(np.median(view.depth[mask])) / view.rig.focal_px
    return float(f"{max(wide, float(np.median(view.sigma[mask]))):.2g}")
