"""The voxel map: bit-identical for any order of its points."""

import os
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError, check_number, check_type
from recon.notices import notify
from recon.records import PointCloud, Voxels, cell_centres
from recon.voxelmap import archive, hits, viewers
from recon.voxelmap.channels import Channel, Scan, eye_of
from recon.voxelmap.coarse import CoarseMaps
from recon.voxelmap.rays import Rays, Sightings
from recon.voxelmap.table import MAX_INDEX, Choose, Rows, in_order, order_of
from recon.voxelmap.views import ViewSets
from recon.voxelmap.weights import Weights

CHANNELS = ("weight", "views", "rays")
"""Names of the optional data of a map besides hits, position and colour."""


class VoxelMap:
    """Counts, mean positions and mean colours of points in an unbounded grid of cubic cells.

    The grid is anchored at 0: a point lies in the cell floor(point / cell_size). Cells keep integer
    sums only, so that insertion order, chunks and merging do not change a bit; positions have a
    resolution of 1e-6 of a cell.

    Parameters
    ----------
    cell_size : float
        Side of a cell, world units.
    channels : iterable of {"weight", "views", "rays"}
        Additional data of the cells: the sum of weights by sigma; the views that saw them; the
        numbers of scans that hit and passed them. A scan is one call of `insert`.
    ray_margin : float
        Distance, in cells, at which free space ends before a point, or two sigma if that is more;
        at 0 it extends to the point's own cell, as in OctoMap.

    Attributes
    ----------
    has_colour : bool
        True if cells have colours, as they do if all points inserted had colours.
    """

    def __init__(
        self, cell_size: float = 1.0, *, channels: Iterable[str] = (), ray_margin: float = 0.0
    ) -> None:
        check_number("cell_size", cell_size, above=0)
        check_number("ray_margin", ray_margin, low=0)
        self.cell_size = float(cell_size)
        self.ray_margin = float(ray_margin)
        self.has_colour = True
        self._hits = hits.HitTable(hits.NARROW)
        self._channels = {name: self._channel(name) for name in sorted(set(channels))}
        self._coarse = CoarseMaps(self.cell_size, type(self))

    def __repr__(self) -> str:
        kept = f", keeps {', '.join(self.channels)}" if self.channels else ""
        return f"VoxelMap({self.num_cells} cells of {self.cell_size:g}{kept})"

    def _channel(self, name: str) -> Channel:
        match name:
            case "weight":
                return Weights(self.cell_size)
            case "views":
                return ViewSets()
            case "rays":
                return Rays(self.cell_size, self.ray_margin)
        raise InputError(f"channel is {name!r}, but one of {', '.join(CHANNELS)} is needed")

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the data of the cells besides hits, position and colour."""
        return tuple(self._channels)

    @property
    def num_cells(self) -> int:
        """Number of cells with a point."""
        return self._hits.num_rows

    @property
    def nbytes(self) -> int:
        """Memory used by hits, positions and colours."""
        return self._hits.nbytes

    def insert(
        self, cloud: PointCloud, origin: ArrayLike | None = None, view: int | None = None
    ) -> None:
        """Add the points of one view, given in the world.

        Parameters
        ----------
        cloud : PointCloud
            Without colours, the whole map loses its colours.
        origin : (3,) array_like, optional
            Camera position, world; needed by a map that keeps rays.
        view : int, optional
            Number of the view; needed by a map that keeps views.

        Raises
        ------
        InputError
            For points that are not finite or out of reach, and if a channel lacks its data; the map
            is then unchanged.
        """
        check_type("cloud", cloud, PointCloud)
        points = np.ascontiguousarray(cloud.points, dtype=np.float64)
        self._check_reach(points)
        scan = Scan(cloud=replace(cloud, points=points), origin=eye_of(origin), view=view)
        for channel in self._channels.values():
            channel.check(scan)
        colours = np.ascontiguousarray(cloud.shown_colours)
        self._note_colour(cloud.colours is not None or not len(cloud))
        rows = self._hits.insert(points, colours, self.cell_size)
        for channel in self._channels.values():
            channel.add(scan, rows)

    def insert_doubtful(self, cloud: PointCloud) -> int:
        """Count points, given in the world, in coarser cells at least as large as their sigma.

        Returns
        -------
        int
            Number of points counted; those without a sigma, or with one above 64 cells, are not.
        """
        check_type("cloud", cloud, PointCloud)
        self._note_colour(cloud.colours is not None or not len(cloud))
        return self._coarse.insert(cloud)

    def _note_colour(self, is_known: bool) -> None:
        """Drop the colours of the map if points without colours are added."""
        if self.has_colour and not is_known:
            self.has_colour = False
            if self.num_cells:
                notify(
                    "colour-missing", "points without colours are added: the map loses its colours"
                )

    @property
    def coarse(self) -> tuple["VoxelMap", ...]:
        """Maps of the points too uncertain for this one, finer cells first."""
        return tuple(one for _, one in sorted(self._coarse.levels.items()))

    def merge(self, other: "VoxelMap") -> None:
        """Add another map with the same cell size and channels, which stays unchanged."""
        check_type("other", other, VoxelMap)
        for name in ("cell_size", "channels"):
            theirs, ours = getattr(other, name), getattr(self, name)
            if theirs != ours:
                raise InputError(f"the other map's {name} is {theirs}, but {ours} is needed")
        self._note_colour(other.has_colour)
        # A copy, since a map may be merged with itself.
        rows = self.add_rows(other._hits.used.copy())
        self._coarse.merge(other._coarse)
        for name, channel in self._channels.items():
            channel.merge(other._channels[name], rows)

    def occupied(self, min_count: int = 5, chosen: Choose | None = None) -> Voxels:
        """The `chosen` cells with at least `min_count` points, ordered by x, then y, then z."""
        check_number("min_count", min_count)
        rows = np.flatnonzero(self._hits.used["count"] >= min_count)
        if chosen is not None:
            rows = rows[chosen(self._hits.rows["index"][rows])]
        return self._voxels(rows[order_of(self._hits.rows["index"][rows])])

    def to_open3d(self, min_count: int = 1) -> Any:
        """An open3d PointCloud of the cells with at least `min_count` points, at their means."""
        return viewers.to_open3d(self.occupied(min_count))

    def to_pyvista(self, min_count: int = 1) -> Any:
        """A pyvista PolyData of the cells with at least `min_count` points, at their centres."""
        return viewers.to_pyvista(self.occupied(min_count))

    def sightings(self) -> Sightings:
        """Every cell that a scan hit or passed, from a map that keeps rays.

        Raises
        ------
        InputError
            If the map does not keep rays.
        """
        self.check_channels(["rays"])
        rays = self._channels["rays"]
        assert isinstance(rays, Rays)
        return rays.sightings()

    def check_channels(self, names: Iterable[str]) -> None:
        """Raise `InputError` unless the map keeps all of these channels."""
        for name in names:
            if name not in self._channels:
                kept = ", ".join(self._channels) or "no channels"
                raise InputError(f"the map keeps {kept}, but {name} is needed")

    def cropped(self, low: ArrayLike, high: ArrayLike) -> "VoxelMap":
        """A map of the cells whose centre lies between two corners (3,), world."""
        corners = np.asarray([low, high], dtype=np.float64)

        def is_inside(index: NDArray[np.integer]) -> NDArray[np.bool_]:
            at = cell_centres(index, self.cell_size)
            return np.asarray(((at >= corners[0]) & (at <= corners[1])).all(axis=1), np.bool_)

        part = VoxelMap(self.cell_size, channels=self.channels, ray_margin=self.ray_margin)
        part.has_colour = self.has_colour
        rows = np.flatnonzero(is_inside(self._hits.used["index"]))
        part.add_rows(self._hits.rows[rows])
        part._channels = {n: c.cropped(rows, is_inside) for n, c in self._channels.items()}
        part._coarse.crop_from(self._coarse, *corners)
        return part

    def save(self, path: str | os.PathLike[str], *, lean: bool = False) -> None:
        """Write the map atomically; the same map yields the same bytes.

        Parameters
        ----------
        path : path of an .npz file
        lean : bool
            Save only index, count and mean colour of the cells, in a third of the space; once
            loaded, the mean position of a cell is its centre.
        """
        archive.save(path, self.columns(lean=lean))

    def columns(self, *, lean: bool = False) -> dict[str, NDArray[Any]]:
        """The arrays of a file."""
        order = order_of(self._hits.used["index"])
        channels = {} if lean else self._channels
        columns: dict[str, Any] = {
            "version": np.array(archive.VERSION),
            "cell_size": np.array(self.cell_size),
            "ray_margin": np.array(self.ray_margin),
            "channels": np.array(list(channels), dtype="U16"),
        }
        columns |= self.hit_columns(lean=lean)
        for channel in channels.values():
            columns |= channel.columns(order)
        return columns | ({} if lean else self._coarse.columns())

    def hit_columns(self, *, lean: bool = False) -> dict[str, NDArray[Any]]:
        """The arrays of a file with hits, positions and colours, in cell order."""
        rows = in_order(self._hits.used)
        return archive.hit_columns(rows, lean=lean, has_colour=self.has_colour)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "VoxelMap":
        """Read a map that `save` wrote; the cells are bit-identical.

        Raises
        ------
        InputError
            For a file that is truncated, of another version or inconsistent.
        """
        content = archive.load(path)
        try:
            return cls.of(content)
        except (InputError, KeyError, ValueError, IndexError) as error:
            raise InputError(f"{path}: not a voxel map ({error})") from error

    @classmethod
    def of(cls, content: archive.Content) -> Self:
        """The map stored in a file."""
        loaded = cls(content.cell_size, channels=content.channels, ray_margin=content.ray_margin)
        loaded.add_rows(content.rows)
        loaded.has_colour = content.has_colour
        for channel in loaded._channels.values():
            channel.restore(content.columns, len(content.rows))
        loaded._coarse.restore(content.columns)
        return loaded

    def _check_reach(self, points: NDArray[np.float64]) -> None:
        farthest = max(points.max(initial=0.0), -points.min(initial=0.0))
        # Written so that NaN fails too.
        if not farthest < MAX_INDEX * self.cell_size:
            raise InputError(
                f"points contain {farthest}, but finite numbers within "
                f"{MAX_INDEX * self.cell_size:g} are needed"
            )

    def add_rows(self, rows: Rows) -> NDArray[np.int64]:
        """Add the sums of cells of a file or another map; return the row of each."""
        return self._hits.merge(rows)

    def _voxels(self, order: NDArray[np.int64]) -> Voxels:
        rows = self._hits.rows[order]
        index = rows["index"].astype(np.int64)
        kept: dict[str, Any] = {}
        for channel in self._channels.values():
            kept |= channel.fields(order, index)
        return Voxels(
            index=index,
            centres=cell_centres(index, self.cell_size),
            means=(index + hits.means(rows)) * self.cell_size,
            counts=rows["count"].astype(np.int64),
            colours=hits.mean_colours(rows) if self.has_colour else None,
            cell_size=self.cell_size,
            **kept,
        )
