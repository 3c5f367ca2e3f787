"""Fusion of the disparities of pairs into one surface: confirmed, fused, meshed."""

import json
from collections import deque
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.files.documents import read_json
from recon.notices import notify
from recon.records import DisparityMap, Mesh, PointCloud, StereoPair
from recon.settings import SurfaceSettings
from recon.surface.assembly import Assembly, MeshParts
from recon.surface.cells import CellCloud, joined
from recon.surface.closing import thickness, watertight
from recon.surface.confirmation import Confirmation
from recon.surface.depth import DepthMap, depth_map
from recon.surface.triangles import mesh_of_pixels, without_floaters
from recon.surface.volume import Volume, check_voxel

CELLS, BLOCKS, MESH, COUNTS = "cells", "blocks", "mesh", "counts.json"
_PIXELS_TO_VOXEL = 2.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surface:
    """The surface seen by the cameras, in the world."""

    parts: Iterable[PointCloud]
    """The points in one or more parts, read one by one as memory may not hold all. They have a
    sigma, and the attribute `views`: the number of views that agree on a point."""
    num_points: int
    mesh_parts: MeshParts | None
    """None if not requested; parts may be read one by one, too."""
    metrics: dict[str, Any]
    """Metrics by their names in metrics.json."""

    @property
    def cloud(self) -> PointCloud:
        """All points at once."""
        return joined(self.parts)

    @property
    def mesh(self) -> Mesh | None:
        """The whole mesh at once."""
        return None if self.mesh_parts is None else self.mesh_parts.whole


@dataclass(slots=True, kw_only=True)
class Counts:
    """Pixels seen by a fusion."""

    num_pixels: int = 0
    num_known: int = 0
    """Pixels with a depth."""
    num_confirmed: int = 0
    """Those of them that other views confirm."""

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(
            **{one.name: getattr(self, one.name) + getattr(other, one.name) for one in fields(self)}
        )

    def see(self, view: DepthMap) -> None:
        """Count a view."""
        self.num_pixels += view.depth.size
        self.num_known += int(view.valid_mask.sum())


class Fusion:
    """Takes pairs with their disparities, one at a time, and returns the surface at the end.

    Of a single pair the pixels are the cloud, and the mesh joins neighbouring ones; of several,
    depths that other views confirm are fused in voxels.

    Parameters
    ----------
    settings : SurfaceSettings
    folder : Path, optional
        Folder for data out of use, which bounds memory; all stays in memory if None.
    """

    def __init__(self, settings: SurfaceSettings, folder: Path | None = None) -> None:
        self.settings = settings
        self.voxel = settings.voxel
        self.folder = folder
        self.counts = Counts()
        self._first: DepthMap | None = None
        self._num_taken = 0
        self._confirmation = Confirmation()
        self._counts_waiting: deque[bool] = deque()
        self._volume: Volume | None = None
        self._cells: CellCloud | None = None

    def add(self, pair: StereoPair, found: DisparityMap) -> DepthMap:
        """Add the next pair, and return its unconfirmed depths."""
        view = self.view_of(pair, found)
        self.add_view(view)
        return view

    def view_of(self, pair: StereoPair, found: DisparityMap) -> DepthMap:
        """The depths of a pair.

        Raises
        ------
        InputError
            For a second pair without a pose.
        """
        if self._num_taken and pair.T_world_left is None:
            raise InputError(
                f"{pair.name} has no pose, but surfaces of several pairs need one each: "
                "give --poses given or estimated"
            )
        return depth_map(pair, found)

    def add_view(self, view: DepthMap, *, counts: bool = True) -> None:
        """Add the next view; one that does not count only confirms others.

        Raises
        ------
        InputError
            If the voxels are too small for its depths or for memory.
        """
        if self._first is None and self.settings.wants_mesh and self.voxel is not None:
            check_voxel(self.voxel, view)  # now: views are fused only after their neighbours
        self._num_taken += 1
        self._first = self._first or view
        self.voxel = self.voxel or suggested_voxel(view)
        if counts:
            self.counts.see(view)
        self._counts_waiting.append(counts)
        self._fuse(self._confirmation.add(view))

    def finish(self) -> Surface:
        """The surface of all pairs."""
        if self._num_taken == 1 and self._first is not None:
            return self._of_one(self._first)
        self._settle()
        cells = self._cells or CellCloud(1.0)
        mesh = self._assembled(cells) if self.settings.wants_mesh else None
        share = self.counts.num_confirmed / max(self.counts.num_known, 1)
        return self._surface(cells, len(cells), mesh, share)

    def _assembled(self, cells: CellCloud) -> MeshParts:
        assembly = Assembly(folder=self.folder and self.folder / MESH)
        for region in self._volume.regions() if self._volume else ():
            assembly.add(region, cells.colours_at(region.vertices.astype(np.float64)))
        parts = assembly.finish()
        return MeshParts.of(self._closed(parts.whole)) if self.settings.watertight else parts

    def save(self, folder: Path) -> None:
        """Write the sums to a folder, for `merge`."""
        self._settle()
        if self._cells is not None:
            self._cells.pages.save(folder / CELLS)
        if self._volume is not None:
            self._volume.pages.save(folder / BLOCKS)
        folder.mkdir(exist_ok=True)
        counts = asdict(self.counts) | {"voxel": self.voxel}
        (folder / COUNTS).write_text(json.dumps(counts, indent=1) + "\n")

    def merge(self, folder: Path) -> None:
        """Add the saved sums of other pairs.

        Raises
        ------
        InputError
            If its voxels have another size, or it is damaged.
        """
        counts, voxel = _read_counts(folder / COUNTS)
        if self.voxel not in (None, voxel):
            raise InputError(f"{folder} has voxels of {voxel}, but {self.voxel} is needed")
        self.voxel = voxel
        self.counts = self.counts + counts
        if voxel is not None:
            self._begun_cells(voxel).merge(folder / CELLS)
            self._begun_volume(voxel).merge(folder / BLOCKS)

    def _settle(self) -> None:
        """Fuse the views that still wait for neighbours."""
        self._fuse(self._confirmation.finish())

    def _fuse(self, views: Iterable[DepthMap]) -> None:
        for view in views:
            if not self._counts_waiting.popleft() or self.voxel is None:
                continue
            self.counts.num_confirmed += int(view.valid_mask.sum())
            self._begun_cells(self.voxel).add(view)
            if self.settings.wants_mesh:
                self._begun_volume(self.voxel).add(view)

    def _begun_cells(self, voxel: float) -> CellCloud:
        self._cells = self._cells or CellCloud(voxel, self.folder and self.folder / CELLS)
        return self._cells

    def _begun_volume(self, voxel: float) -> Volume:
        self._volume = self._volume or Volume(voxel, self.folder and self.folder / BLOCKS)
        return self._volume

    def _of_one(self, view: DepthMap) -> Surface:
        mask = view.valid_mask
        cloud = PointCloud(
            points=view.points(mask),
            colours=view.colours[mask],
            sigma=view.sigma[mask].astype(np.float64),
            attributes={"views": np.ones(int(mask.sum()), np.uint8)},
        )
        mesh = None
        if self.settings.wants_mesh:
            found = without_floaters(mesh_of_pixels(view), smallest_share=1e-4)
            mesh = MeshParts.of(self._closed(found))
        return self._surface([cloud], len(cloud), mesh, None)

    def _closed(self, mesh: Mesh) -> Mesh:
        if not self.settings.watertight or not len(mesh):
            return mesh
        closed = watertight(mesh)
        if self.voxel is not None and (thick := thickness(closed)) < self.voxel:
            notify(
                "mesh-without-thickness",
                f"the closed mesh is {thick:.2g} thick on average, less than a voxel of "
                f"{self.voxel:g}: only one side was seen, and the other coincides with it",
            )
        return closed

    def _surface(
        self, parts: Iterable[PointCloud], num: int, mesh: MeshParts | None, share: float | None
    ) -> Surface:
        metrics: dict[str, Any] = {
            "num_dense_points": num,
            "dense_share": self.counts.num_known / max(self.counts.num_pixels, 1),
            "dense_confirmed_share": share,
        }
        if mesh is not None:
            metrics |= {
                "voxel": self.voxel,
                "num_triangles": len(mesh),
                "mesh_area": mesh.area,
                "largest_piece_share": mesh.largest_share,
            }
        return Surface(parts=parts, num_points=num, mesh_parts=mesh, metrics=metrics)


def _read_counts(path: Path) -> tuple[Counts, float | None]:
    """Counts and voxel size of a saved fusion; the latter is None if no depth was known."""
    document = read_json(path)
    try:
        voxel = document.pop("voxel")
        return Counts(**{name: int(n) for name, n in document.items()}), voxel and float(voxel)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{path} does not hold the counts of a surface ({error})") from error


def suggested_voxel(view: DepthMap) -> float | None:
    """Two pixels at the median depth of a view, or its median sigma if that is larger."""
    mask: NDArray[np.bool_] = view.valid_mask
    if not mask.any():
        return None
    wide = _PIXELS_TO_VOXEL * float(np.median(view.depth[mask])) / view.rig.focal_px
    return float(f"{max(wide, float(np.median(view.sigma[mask]))):.2g}")
