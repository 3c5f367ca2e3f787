"""One mesh from those of regions of space, which share the vertices along their borders."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from recon.records import Mesh, MeshPart
from recon.surface.triangles import SMALLEST_SHARE, piece_areas, vertex_pieces, with_normals
from recon.voxelmap.archive import read_columns

Numbers = NDArray[np.int64]
Bools = NDArray[np.bool_]
Floating = NDArray[np.floating]


class RegionMesh(NamedTuple):
    """The triangles of a region."""

    vertices: Floating
    normals: Floating
    triangles: NDArray[np.int32]
    shared: Bools
    """(V,) vertices that other regions use too; they are bit-identical there."""


class _Stored(NamedTuple):
    """The mesh of a region, with the data that other regions need."""

    vertices: Floating
    normals: Floating
    colours: NDArray[np.uint8]
    triangles: NDArray[np.int32]
    shared: Bools
    piece: Numbers
    """(V,) number of the connected piece, over all regions."""


class Assembly:
    """Joins the meshes of regions into one, without its floaters.

    Parameters
    ----------
    smallest_share : float
        Of the area; smaller connected pieces are removed.
    folder : Path, optional
        Folder for the parts; all stay in memory if None.
    """

    def __init__(self, smallest_share: float = SMALLEST_SHARE, folder: Path | None = None) -> None:
        self.smallest_share = smallest_share
        self.folder = folder
        self._parts: list[_Stored | Path] = []
        self._places: list[Floating] = []
        """Of the shared vertices of each part."""
        self._numbers: list[Numbers] = []
        """Of their pieces."""
        self._areas: list[NDArray[np.float64]] = []
        """Of the pieces within each part."""

    def add(self, found: RegionMesh, colours: NDArray[np.uint8]) -> None:
        """Add the mesh of the next region, with the colours of its vertices."""
        mesh = Mesh(vertices=found.vertices.astype(np.float64), triangles=found.triangles)
        piece = vertex_pieces(mesh)
        areas = piece_areas(mesh, piece)
        piece = piece + sum(map(len, self._areas))
        self._areas.append(areas)
        self._places.append(found.vertices[found.shared])
        self._numbers.append(piece[found.shared])
        self._keep(
            _Stored(found.vertices, found.normals, colours, found.triangles, found.shared, piece)
        )

    def _keep(self, part: _Stored) -> None:
        if self.folder is None:
            self._parts.append(part)
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"{len(self._parts):06d}.npz"
        with path.open("wb") as file:
            np.savez(file, **part._asdict())
        self._parts.append(path)

    def finish(self) -> "MeshParts":
        """The mesh of all regions."""
        if not self._parts:
            return MeshParts.of(Mesh.none())
        places, numbers = np.concatenate(self._places), np.concatenate(self._numbers)
        _, first, same = np.unique(places, axis=0, return_index=True, return_inverse=True)
        owner = first[same.reshape(-1)]
        areas = np.concatenate(self._areas)
        edges = np.ones(len(numbers), np.int8), (numbers, numbers[owner])
        whole = connected_components(coo_array(edges, shape=(len(areas),) * 2), directed=False)[1]
        wholes: NDArray[Any] = np.bincount(whole, weights=areas)
        is_kept = wholes >= self.smallest_share * wholes.sum()
        return MeshParts(self._parts, owner, is_kept[whole], wholes[is_kept])


class MeshParts:
    """A mesh in parts that can be read one by one, repeatedly."""

    def __init__(
        self,
        parts: list[_Stored | Path],
        owner: Numbers,
        is_kept: Bools,
        areas: NDArray[np.float64],
    ) -> None:
        self._stored = parts
        self._owner = owner
        """(S,) of all shared vertices, the first that is the same."""
        self._is_kept = is_kept
        """By the number of a piece."""
        self.area = float(areas.sum())
        self.largest_share = float(areas.max(initial=0) / (self.area or 1.0))
        self.num_vertices = self.num_triangles = 0
        for part in self:
            self.num_vertices += len(part.vertices)
            self.num_triangles += len(part.triangles)

    @classmethod
    def of(cls, mesh: Mesh) -> "MeshParts":
        """A mesh in one part, whole as it is."""
        piece = vertex_pieces(mesh)
        areas = piece_areas(mesh, piece)
        normals = with_normals(mesh).normals if mesh.normals is None else mesh.normals
        assert normals is not None
        colours = np.zeros(mesh.vertices.shape, np.uint8) if mesh.colours is None else mesh.colours
        shared = np.zeros(len(piece), np.bool_)
        part = _Stored(mesh.vertices, normals, colours, mesh.triangles, shared, piece)
        return cls([part], np.zeros(0, np.int64), np.ones(len(areas), np.bool_), areas)

    def __len__(self) -> int:
        return self.num_triangles

    def __iter__(self) -> Iterator[MeshPart]:
        """Yield the parts; a shared vertex belongs to the first that uses it."""
        numbers = np.full(len(self._owner), -1, np.int64)
        num, first = 0, 0
        for stored in map(_read, self._stored):
            owner = self._owner[first : first + int(stored.shared.sum())]
            is_own = self._is_kept[stored.piece]
            is_own[stored.shared] &= owner == first + np.arange(len(owner))
            number = num - 1 + np.cumsum(is_own)
            own = numbers[first : first + len(owner)]
            own[:] = number[stored.shared]
            number[stored.shared] = numbers[owner]
            num, first = num + int(is_own.sum()), first + len(owner)
            kept = stored.triangles[self._is_kept[stored.piece[stored.triangles[:, 0]]]]
            yield MeshPart(
                vertices=stored.vertices[is_own].astype(np.float64),
                normals=stored.normals[is_own].astype(np.float64),
                colours=stored.colours[is_own],
                triangles=number[kept].astype(np.int32),
            )

    @property
    def whole(self) -> Mesh:
        """All parts in one."""
        return _joined(list(self))

    def coarse(self, most: int) -> Mesh:
        """About `most` triangles at most: vertices of the same cell become one."""
        if len(self) <= most:
            return self.whole
        # An area meets 1.5 times as many cells as fit into it, on average; each has two triangles.
        cell = np.sqrt(3 * self.area / most)
        coarse, number, num = [], np.empty(self.num_vertices, np.int32), 0
        first = 0
        for part in self:
            cells = np.floor(part.vertices / cell)
            _, chosen, same = np.unique(cells, axis=0, return_index=True, return_inverse=True)
            number[first : first + len(cells)] = num + same.reshape(-1)
            first, num = first + len(cells), num + len(chosen)
            a, b, c = number[part.triangles].T
            coarse.append(
                MeshPart(
                    vertices=part.vertices[chosen],
                    normals=part.normals[chosen],
                    colours=part.colours[chosen],
                    triangles=np.stack([a, b, c], axis=1)[(a != b) & (b != c) & (c != a)],
                )
            )
        return _joined(coarse)


def _joined(parts: list[MeshPart]) -> Mesh:
    names = "vertices", "triangles", "colours", "normals"
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(one, name) for one in parts]) for name in names
    }
    return Mesh(**columns)


def _read(stored: _Stored | Path) -> _Stored:
    return _Stored(**read_columns(stored)) if isinstance(stored, Path) else stored
