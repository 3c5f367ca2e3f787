"""The layout of a map: ground, supports and walls, and the components between them."""

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
"""Cells lower than this above a detected floor belong to it ..."""
CLEARANCE_SIGMAS = 3.0
"""... or lower than this number of standard deviations of its own cells."""
WALL_CELLS = 1.0
"""Maximum distance of a cell on a wall."""
REACH_CELLS = 2.5
"""Maximum distance of neighbouring cells of one object, larger where cells are sparse."""
SMALLEST_HOST = 12
"""Minimum number of cells of a component that others are stacked on."""
WIDER = 2.0
"""A floor under an object that all views look at is larger than the object by at least this
factor."""
MOST_BELOW = 0.1
"""Maximum share of the cells below that floor: a bed has legs, so its top is none."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layout:
    """A map in its level frame: y up, floor at y = `floor`."""

    cells: Voxels
    """Means and centres in the level frame; cell indices are those of the map."""
    T_world_level: Array
    """(4, 4)"""
    floor: float
    """Height of the floor, or of the lowest cell if no floor was found."""
    planes: tuple[FoundPlane, ...]
    """World."""
    component: Labels
    """(K,) 0, 1, ...; -1 = on a plane, or part of what supports one."""
    supports: tuple[Support, ...] = ()
    """The raised planes, in their order."""

    @property
    def has_floor(self) -> bool:
        """True if a ground plane was found."""
        return any(plane.role == "ground" for plane in self.planes)

    @property
    def num_components(self) -> int:
        """Number of components."""
        return int(self.component.max(initial=-1)) + 1

    def height_under(self, cells: Voxels) -> float:
        """Height of what cells stand on: the highest support under them, otherwise the floor."""
        under = self._under(cells)
        return self.floor if under is None else self.supports[under].height

    def support(self, cells: Voxels) -> int | None:
        """Id of the plane that cells stand on; None if nothing known supports them."""
        under = self._under(cells)
        role = "ground" if under is None else "support"
        if not self.has_floor or is_hovering(cells, self.height_under(cells)):
            return None
        return [plane.id for plane in self.planes if plane.role == role][under or 0]

    def _under(self, cells: Voxels) -> int | None:
        """Index of the highest support below most of the cells."""
        low = float(cells.means[:, 1].min())
        under = [
            (one.height, number)
            for number, one in enumerate(self.supports)
            if one.height < low + cells.cell_size and one.holds(cells).mean() > 0.5
        ]
        return max(under)[1] if under else None


def lay_out(voxels: Voxels, settings: RecognitionSettings, focus: Focus | None = None) -> Layout:
    """Remove the planes from a map and label the connected components of the rest.

    Parameters
    ----------
    focus : Focus, optional
        Position that all views look at: everything there is one object.
    """
    if settings.ground is not None:
        return _on_known_ground(voxels, settings, settings.ground)
    T_level_world = level_plane(voxels.means) if len(voxels) else None
    if T_level_world is not None:
        cells = moved_cells(voxels, T_level_world)
        on_floor = cells.means[:, 1] < _clearance(cells, settings)
        if focus is None or _carries_all(cells, on_floor):
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
    """Remove floor, walls and supports; anything below the floor is seen past its edge."""
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
    """Component (K,) of each standing cell; -1 for the others."""
    points = cells.means[standing]
    label = linked(points, REACH_CELLS * cells.cell_size)
    component = np.full(len(cells), -1, dtype=np.int32)
    component[standing] = stacked(points, label, SMALLEST_HOST)
    return component


def _gathered(component: Labels, points_world: Array, focus: Focus | None) -> Labels:
    """Merge the components at the position that all views look at."""
    if focus is None or not (component >= 0).any():
        return component
    kept = component >= 0
    inside = np.bincount(component[kept], focus.holds(points_world[kept]))
    here = inside > 0.5 * np.bincount(component[kept])
    merged = np.where(here, np.flatnonzero(here).min(initial=len(here)), np.arange(len(here)))
    gathered = component.copy()
    gathered[kept] = merged[component[kept]]
    ordered: Labels = in_order_of_appearance(gathered)
    return ordered


def _clearance(cells: Voxels, settings: RecognitionSettings) -> float:
    """Height up to which cells above a detected floor at y = 0 belong to it."""
    if settings.ground_clearance is not None:
        return settings.ground_clearance
    height = cells.means[:, 1]
    own = np.abs(height) < CLEARANCE_CELLS * cells.cell_size
    spread = 1.4826 * float(np.median(np.abs(height[own]))) if own.any() else 0.0
    return max(CLEARANCE_CELLS * cells.cell_size, CLEARANCE_SIGMAS * spread)


def _carries_all(cells: Voxels, on_floor: Mask) -> bool:
    """True if a floor extends beyond what stands on it, with next to nothing below."""
    is_below = cells.means[:, 1] < -CLEARANCE_CELLS * cells.cell_size
    if is_below.mean() > MOST_BELOW:
        return False
    return _footprint(cells.means[on_floor]) > WIDER * _footprint(cells.means[~on_floor])


def _footprint(points: Array) -> float:
    try:
        return float(ConvexHull(points[:, ::2]).volume)
    except (QhullError, ValueError):
        return 0.0


def _board(height: float) -> Plane:
    return Plane(point=np.array([0.0, height, 0.0]), normal=np.array(WORLD_UP))


def _plane(number: int, plane: Plane, cells: Voxels, role: PlaneRole) -> FoundPlane:
    """A plane in the world frame, with its point in the middle of its cells."""
    middle = cells.means.mean(axis=0) if len(cells) else plane.point
    foot = middle - ((middle - plane.point) @ plane.normal) * plane.normal
    area = len(cells) * cells.cell_size**2
    return FoundPlane(id=number, point=foot, normal=plane.normal, area=area, role=role)
