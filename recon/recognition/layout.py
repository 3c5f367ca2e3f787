"""The layout of a map: planes that things stand on or before, and the components between them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from recon.geometry import WORLD_UP, invert
from recon.recognition.connectivity import in_order_of_appearance, linked, stacked
from recon.recognition.frames import moved, moved_cells
from recon.recognition.naming.visibility import is_hovering
from recon.recognition.segments.focus import Focus
from recon.recognition.segments.ground import level_plane
from recon.recognition.segments.supports import Support, find_supports
from recon.recognition.segments.walls import find_walls
from recon.records import FoundPlane, Plane, Voxels
from recon.records.objects import PlaneRole
from recon.settings import RecognitionSettings

Array = NDArray[np.float64]
Labels = NDArray[np.int32]
Mask = NDArray[np.bool_]

CLEARANCE_CELLS = 1.5
"""Cells lower over a found floor than this belong to it ..."""
CLEARANCE_SIGMAS = 3.0
"""... or than so many deviations of its own cells."""
WALL_CELLS = 1.0
"""Distance from a wall up to which a cell lies on it."""
REACH_CELLS = 2.5
"""Cells of one object lie at most so far apart, more where cells lie sparsely."""
SMALLEST_HOST = 12
"""Cells of a component that others stand on or under."""
WIDER = 2.0
"""A floor under a thing that all views look at is so many times as large as the thing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layout:
    """A map in its level frame: y up, the floor at y = `floor`."""

    cells: Voxels
    """Means and centres level; cell numbers are those of the map."""
    T_world_level: Array
    """(4, 4)"""
    floor: float
    """Height of the floor; of the lowest cell where none was found."""
    planes: tuple[FoundPlane, ...]
    """World."""
    component: Labels
    """(K,) 0, 1, ...; -1 = on a plane, or of what holds one up."""
    supports: tuple[Support, ...] = ()
    """Those of the planes that are raised, in their order."""

    @property
    def has_floor(self) -> bool:
        """True where a plane was found that things stand on."""
        return any(plane.role == "ground" for plane in self.planes)

    @property
    def num_components(self) -> int:
        """Number of components."""
        return int(self.component.max(initial=-1)) + 1

    def height_under(self, cells: Voxels) -> float:
        """Height of what cells stand on: of the highest support under them, else of the floor."""
        under = self._under(cells)
        return self.floor if under is None else self.supports[under].height

    def support(self, cells: Voxels) -> int | None:
        """Id of the plane that cells stand on; None where nothing that is known holds them."""
        under = self._under(cells)
        role = "ground" if under is None else "support"
        if not self.has_floor or is_hovering(cells, self.height_under(cells)):
            return None
        return [plane.id for plane in self.planes if plane.role == role][under or 0]

    def _under(self, cells: Voxels) -> int | None:
        """Number of the highest support that most of the cells lie over."""
        low = float(cells.means[:, 1].min())
        under = [
            (one.height, number)
            for number, one in enumerate(self.supports)
            if one.height < low + cells.cell_size and one.holds(cells).mean() > 0.5
        ]
        return max(under)[1] if under else None


def lay_out(voxels: Voxels, settings: RecognitionSettings, focus: Focus | None = None) -> Layout:
    """Take the planes off a map and number what hangs together in the rest.

    Parameters
    ----------
    focus : Focus, optional
        Place that all views look at: what is there is one thing.
    """
    if settings.ground is not None:
        return _on_known_ground(voxels, settings, settings.ground)
    T_level_world = level_plane(voxels.means) if len(voxels) else None
    if T_level_world is not None:
        cells = moved_cells(voxels, T_level_world)
        on_floor = cells.means[:, 1] < _clearance(cells, settings)
        if focus is None or _is_wider(cells, on_floor):
            return _on_found_floor(voxels, cells, T_level_world, on_floor, focus)
    return _without_floor(voxels, focus)


def _on_known_ground(voxels: Voxels, settings: RecognitionSettings, ground: float) -> Layout:
    above = voxels.centres[:, 1] >= ground + settings.clearance(voxels.cell_size)
    return Layout(
        cells=voxels,
        T_world_level=np.eye(4),
        floor=ground,
        planes=(_plane(0, _board(ground), voxels.select(~above), "ground"),),
        component=_numbered(voxels, above),
    )


def _without_floor(voxels: Voxels, focus: Focus | None) -> Layout:
    standing = np.ones(len(voxels), dtype=bool)
    component = _numbered(voxels, standing)
    return Layout(
        cells=voxels,
        T_world_level=np.eye(4),
        floor=float(voxels.means[:, 1].min(initial=0.0)),
        planes=(),
        component=_gathered(component, voxels.means, focus),
    )


def _on_found_floor(
    voxels: Voxels, cells: Voxels, T_level_world: Array, on_floor: Mask, focus: Focus | None
) -> Layout:
    """Floor, walls and supports taken off; what lies deeper than the floor is seen beside it."""
    T_world_level = invert(T_level_world)
    floor = moved(_board(0.0), T_world_level)
    planes = [_plane(0, floor, voxels.select(on_floor), "ground")]
    standing = ~on_floor
    tolerance = WALL_CELLS * cells.cell_size
    walls = [] if focus else find_walls(cells.means[standing], cells.means, tolerance)
    rows = np.flatnonzero(standing)
    for number, wall in enumerate(walls, start=1):
        own = rows[wall.mask]
        standing[own] = False
        planes.append(_plane(number, moved(wall.plane, T_world_level), voxels.select(own), "wall"))
    supports = [] if focus else find_supports(cells, standing, int(on_floor.sum()))
    for number, support in enumerate(supports, start=len(planes)):
        standing[support.board] = standing[support.legs] = False
        board = moved(_board(support.height), T_world_level)
        planes.append(_plane(number, board, voxels.select(support.board), "support"))
    component = _numbered(cells, standing)
    return Layout(
        cells=cells,
        T_world_level=T_world_level,
        floor=0.0,
        planes=tuple(planes),
        component=_gathered(component, voxels.means, focus),
        supports=tuple(supports),
    )


def _numbered(cells: Voxels, standing: Mask) -> Labels:
    """Component (K,) of each standing cell; -1 = of the others."""
    points = cells.means[standing]
    label = linked(points, REACH_CELLS * cells.cell_size)
    component = np.full(len(cells), -1, dtype=np.int32)
    component[standing] = stacked(points, label, SMALLEST_HOST)
    return component


def _gathered(component: Labels, points_world: Array, focus: Focus | None) -> Labels:
    """The components at the place that all views look at as one."""
    if focus is None or not (component >= 0).any():
        return component
    kept = component >= 0
    inside = np.bincount(component[kept], focus.holds(points_world[kept]))
    here = inside > 0.5 * np.bincount(component[kept])
    merged = np.where(here, np.flatnonzero(here).min(initial=len(here)), np.arange(len(here)))
    gathered = component.copy()
    gathered[kept] = merged[component[kept]]
    return in_order_of_appearance(gathered)


def _clearance(cells: Voxels, settings: RecognitionSettings) -> float:
    """Height up to which cells over a found floor at y = 0 belong to it."""
    if settings.ground_clearance is not None:
        return settings.ground_clearance
    height = cells.means[:, 1]
    own = np.abs(height) < CLEARANCE_CELLS * cells.cell_size
    spread = 1.4826 * float(np.median(np.abs(height[own]))) if own.any() else 0.0
    return max(CLEARANCE_CELLS * cells.cell_size, CLEARANCE_SIGMAS * spread)


def _is_wider(cells: Voxels, on_floor: Mask) -> bool:
    """True where a floor reaches beyond what stands on it."""
    return _footprint(cells.means[on_floor]) > WIDER * _footprint(cells.means[~on_floor])


def _footprint(points: Array) -> float:
    try:
        return float(ConvexHull(points[:, ::2]).volume)
    except (QhullError, ValueError):
        return 0.0


def _board(height: float) -> Plane:
    return Plane(point=np.array([0.0, height, 0.0]), normal=np.array(WORLD_UP))


def _plane(number: int, plane: Plane, cells: Voxels, role: PlaneRole) -> FoundPlane:
    """A plane in the world, its point in the middle of its cells."""
    middle = cells.means.mean(axis=0) if len(cells) else plane.point
    foot = middle - ((middle - plane.point) @ plane.normal) * plane.normal
    area = len(cells) * cells.cell_size**2
    return FoundPlane(id=number, point=foot, normal=plane.normal, area=area, role=role)
