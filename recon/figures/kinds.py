"""Kinds of figures, and the subjects they are drawn from."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import GroundGrid, Mesh, Reconstruction

if TYPE_CHECKING:
    from recon.figures.canvas import Sheet

Arrays = Mapping[str, NDArray[Any]]
"""Arrays that a figure shows, by name, as in its `.npz`."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Subject:
    """The subject of a figure: a run with a map, arrays kept for one figure, or both."""

    run: Reconstruction[Any] | None = None
    kept: Arrays | None = None
    """Kept by the run for this figure, as they do not follow from its map."""
    mesh: Mesh | None = None
    cameras: NDArray[np.float64] | None = None
    """(N, 3) positions of the cameras that saw the mesh."""
    unit: str = "world units"
    """Of lengths."""
    is_recorded: bool = False
    """True if the run is a real recording; the default view is then from behind the camera."""
    asked_view: str = "default"
    floor: GroundGrid | None = None
    """States of the floor cells, if they were found before."""

    @property
    def mapped(self) -> Reconstruction[Any]:
        """The run's map and its associated results.

        Raises
        ------
        InputError
            If the run has no map.
        """
        if self.run is None:
            raise InputError("the run has no map.npz, but this kind of figure shows the map")
        return self.run

    @property
    def arrays(self) -> Arrays:
        """The arrays that the run kept for this figure.

        Raises
        ------
        InputError
            If it kept none.
        """
        if self.kept is None:
            raise InputError("the run kept no arrays for this kind of figure")
        return self.kept

    @property
    def view(self) -> str:
        """The view of a 3D figure."""
        is_seen = self.is_recorded and self.run is not None and len(self.run.trajectory) > 0
        return "ego" if self.asked_view == "default" and is_seen else self.asked_view

    @property
    def first(self) -> NDArray[np.float64] | None:
        """(4, 4) pose of the first camera."""
        poses: NDArray[np.float64] = self.mapped.trajectory.T_world_left
        return poses[0] if len(poses) else None

    @property
    def has_rays(self) -> bool:
        """True if the map keeps the rays."""
        return "rays" in getattr(self.mapped.map, "channels", ())

    @property
    def states(self) -> GroundGrid | None:
        """Free, occupied and unknown floor, by rays or visible ground; None if none is seen."""
        if self.floor is not None:
            return self.floor
        if self.has_rays:
            from recon.voxelmap.ground import navigation

            floor = navigation(self.mapped.voxels, self.mapped.map.sightings())
            return floor if floor.cells.size else None
        if not self.is_recorded:
            return None
        from recon.figures.free_ground import states_by_ground

        return states_by_ground(self.mapped.voxels)


def _drawable(subject: Subject) -> str | None:
    return None


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """One kind of figure.

    A plug-in of the group `recon.figures` is an instance of this class.
    """

    draw: Callable[[Subject, "Sheet"], Any]
    """Draws a subject on a sheet; returns the matplotlib Figure."""
    data: Callable[[Subject], Arrays]
    """The arrays that are drawn, by name."""
    size: tuple[int, int] = (1200, 900)
    """Default size, pixels."""
    has_view: bool = False
    """True if it has a selectable viewpoint."""
    is_kept: bool = False
    """True if it is drawn from arrays kept by the run, not from its map."""
    needs_mesh: bool = False
    """True if it shows the run's mesh."""
    lack: Callable[[Subject], str | None] = _drawable
    """Names the part that a run with a map lacks for it; None if it can be drawn."""
