"""Signed distances to the surface, in blocks of voxels near it (Curless and Levoy, 1996).

Each depth is weighted by its sigma. Open3D's VoxelBlockGrid extracts the triangles from the blocks;
they are filled here, as it does not support pixel weights.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.geometry import invert
from recon.libraries import load_open3d
from recon.records import Mesh
from recon.surface.assembly import RegionMesh
from recon.surface.breaks import unsure_at_breaks
from recon.surface.depth import DepthMap, Floats
from recon.surface.integration import (
    BLOCK,
    DEEPEST,
    MAX_SIGMA,
    NUM_STEPS,
    UNITS,
    VOXELS,
    View,
    fuse,
    seen_mask,
    touch,
)
from recon.surface.pages import Key, Pages, page_path, read_page, regions_of, saved_keys
from recon.surface.triangles import with_normals
from recon.voxelmap.table import CellTable, Rows

Array = NDArray[np.float64]
Keys = NDArray[np.int32]

_MIN_WEIGHT = 0.04
"""Minimum weight of a surface voxel; one view with a sigma of one voxel yields 0.8."""
_MAX_BLOCKS = 2_000_000
"""Maximum number of blocks of one view, for memory."""
_HOPELESS = 10.0
"""Multiple of the maximum sigma by which no later view, however close, is expected to be surer."""
_BLOCK = np.dtype([("index", np.int32, (3,))])
_REGION = 16
"""Blocks along each side of a region."""


class Volume:
    """Signed distances around a surface, fused from depth maps.

    A view updates all visible blocks that it or an earlier view has created. Integer sums of parts
    can be added exactly.

    Parameters
    ----------
    voxel : float
        Side of a voxel, world units.
    folder : Path, optional
        Folder for regions out of use, which bounds memory; all stay in memory if None.
    """

    def __init__(self, voxel: float, folder: Path | None = None) -> None:
        self.voxel = voxel
        self.pages = Pages(VOXELS, _REGION, folder)

    def add(self, view: DepthMap) -> None:
        """Fuse the depths of a view, which also carves free space."""
        view = unsure_at_breaks(view)
        sure = view.where(view.sigma <= MAX_SIGMA * self.voxel)
        if not sure.valid_mask.any():
            return
        blocks = self._met(sure)
        for key, rows in regions_of(blocks, _REGION):
            self.pages.page(key).enter(blocks[rows])
        seen = View(sure.depth, sure.sigma, view.camera, float(np.nanmax(sure.depth)))
        T_left_world = invert(view.T_world_left)
        for key in self._in_sight(seen, T_left_world):
            fuse(self.pages.page(key).used, seen, T_left_world, self.voxel)

    def merge(self, folder: Path) -> None:
        """Add the saved pages of another volume."""
        for key in saved_keys(folder):
            other = read_page(page_path(folder, key), VOXELS)
            table = self.pages.page(key)
            rows = table.enter(other["index"])
            for name in ("distance", "weight"):
                table.rows[name][rows] += other[name]

    def _met(self, view: DepthMap) -> Keys:
        """(B, 3) blocks that the surface of a view passes through."""
        side, blocks, done = BLOCK * self.voxel, CellTable(_BLOCK), 0
        points, start = view.points(view.valid_mask) / side, view.position / side
        while done < len(points):
            done, blocks.num_rows = touch(*blocks.arrays, points, start, done)
            _check_blocks(self.voxel, blocks.num_rows)
            if len(blocks.rows) - blocks.num_rows < NUM_STEPS:
                blocks.grow()
        index: Keys = blocks.used["index"]
        return index

    def _in_sight(self, view: View, T_left_world: Array) -> list[Key]:
        keys, side = self.pages.keys, _REGION * BLOCK * self.voxel
        cubes = np.array(keys, np.int32)
        mask = seen_mask(cubes, view, T_left_world, side, DEEPEST * self.voxel)
        return [key for key, is_seen in zip(keys, mask, strict=True) if is_seen]

    def regions(self) -> Iterator[RegionMesh]:
        """Yield the surface where distances change sign, region by region; holes remain."""
        for key in self.pages.keys:
            found = self._region(key)
            if found is not None:
                yield found

    def _region(self, key: Key) -> RegionMesh | None:
        """The surface in a region, with the normals that its neighbours agree on."""
        blocks = self.pages.around(key, 1).used
        if not (blocks["weight"] > _MIN_WEIGHT * UNITS).any():
            return None
        vertices, triangles = _ordered(*_extracted(blocks, self.voxel))
        # Neighbouring regions extract bit-identical triangles; each is kept once.
        middle = vertices[triangles].mean(axis=1, dtype=np.float64)
        own = (np.floor(middle / (_REGION * BLOCK * self.voxel)) == key).all(axis=1)
        if not own.any():
            return None
        used, renumbered = np.unique(triangles[own], return_inverse=True)
        others = np.zeros(len(vertices), np.bool_)
        others[triangles[~own]] = True
        mesh = with_normals(Mesh(vertices=vertices.astype(np.float64), triangles=triangles))
        assert mesh.normals is not None
        return RegionMesh(
            vertices=vertices[used],
            normals=mesh.normals[used].astype(np.float32),
            triangles=renumbered.reshape(-1, 3).astype(np.int32),
            shared=others[used],
        )


def check_voxel(voxel: float, view: DepthMap) -> None:
    """Raise `InputError` for voxels that the depths of a view cannot fill, or memory not hold."""
    if not view.valid_mask.any():
        return
    smallest = float(np.nanmin(view.sigma[view.valid_mask]))
    if smallest > _HOPELESS * MAX_SIGMA * voxel:
        raise InputError(
            f"voxels of {voxel:g} would stay empty, as the depths of the first pair have a sigma "
            f"of {smallest:.2g} or more: give --voxel {smallest:.2g} or more"
        )
    sure = view.depth[view.sigma <= MAX_SIGMA * voxel].astype(np.float64)
    area = float((sure**2).sum()) / view.rig.focal_px**2
    # No projection of a cube is larger than its side squared times this root.
    _check_blocks(voxel, area / (np.sqrt(3.0) * (BLOCK * voxel) ** 2))


def _check_blocks(voxel: float, number: float) -> None:
    if number > _MAX_BLOCKS:
        raise InputError(
            f"voxels of {voxel:g} make more than {_MAX_BLOCKS} blocks, which do not fit into "
            "memory: give a larger --voxel"
        )


def _extracted(blocks: Rows, voxel: float) -> tuple[Floats, Keys]:
    """Vertices and triangles that Open3D extracts from blocks."""
    none = np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32)
    try:
        found = _grid(blocks, voxel).extract_triangle_mesh(weight_threshold=_MIN_WEIGHT)
    except RuntimeError as error:
        # Open3D fails at setting colours of a mesh without vertices.
        if "SetVertexColors" not in str(error):
            raise
        return none
    if "positions" not in found.vertex or not len(found.vertex.positions):
        return none
    triangles = found.triangle.indices.numpy().astype(np.int32)
    return found.vertex.positions.numpy(), triangles


def _grid(blocks: Rows, voxel: float) -> Any:
    """Open3D's grid with the same blocks."""
    core = load_open3d().core
    grid = load_open3d().t.geometry.VoxelBlockGrid(
        attr_names=("tsdf", "weight"),
        attr_dtypes=(core.float32, core.float32),
        attr_channels=((1), (1)),
        voxel_size=voxel,
        block_resolution=BLOCK,
        block_count=len(blocks),
    )
    rows, _ = grid.hashmap().activate(core.Tensor(np.ascontiguousarray(blocks["index"])))
    at, cube = rows.numpy(), (-1, BLOCK, BLOCK, BLOCK, 1)
    distance = blocks["distance"] / np.maximum(blocks["weight"], 1)
    grid.attribute("tsdf").numpy()[at] = distance.reshape(cube)
    grid.attribute("weight").numpy()[at] = (blocks["weight"] / UNITS).reshape(cube)
    return grid


def _ordered(vertices: Floats, triangles: Keys) -> tuple[Floats, Keys]:
    """The mesh in an order independent of Open3D's threads, with coincident vertices merged."""
    vertices, number = _distinct(vertices)
    triangles = number[triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    first = triangles.argmin(axis=1)
    turned = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return vertices, _distinct(turned)[0]


def _distinct(rows: NDArray[Any]) -> tuple[NDArray[Any], Keys]:
    """Rows (N, 3) in order, each once, and the number of each given one."""
    order = np.lexsort(rows.T)
    ordered = rows[order]
    is_new = np.ones(len(rows), np.bool_)
    is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    number = np.empty(len(rows), np.int32)
    number[order] = np.cumsum(is_new) - 1
    return ordered[is_new], number
