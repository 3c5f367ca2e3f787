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
"""Arrays that a figure shows, by name, as its `.npz` holds them."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Subject:
    """Subject of a figure: a run with a map, or the arrays that it kept for one figure, or both."""

    run: Reconstruction[Any] | None = None
    kept: Arrays | None = None
    """Left by the run for this figure, as its map does not tell them."""
    mesh: Mesh | None = None
    cameras: NDArray[np.float64] | None = None
    """(N, 3) where the cameras stood that saw the mesh."""
    unit: str = "world units"
    """Of lengths."""
    is_recorded: bool = False
    """True where the run saw the real world; by default it is then seen from behind the camera."""
    asked_view: str = "default"

    @property
    def mapped(self) -> Reconstruction[Any]:
        """The run's map and what belongs to it.

        Raises
        ------
        InputError
            Where the run left none.
        """
        if self.run is None:
            raise InputError("the run holds no map.npz, but this kind of figure shows the map")
        return self.run

    @property
    def arrays(self) -> Arrays:
        """The arrays that the run kept for this figure.

        Raises
        ------
        InputError
            Where it kept nothing.
        """
        if self.kept is None:
            raise InputError("the run kept no arrays for this kind of figure")
        return self.kept

    @property
    def view(self) -> str:
        """The view of a figure in space."""
        is_seen = self.is_recorded and self.run is not None and len(self.run.trajectory) > 0
        return "ego" if self.asked_view == "default" and is_seen else self.asked_view

    @property
    def first(self) -> NDArray[np.float64] | None:
        """(4, 4) pose of the first camera."""
        poses: NDArray[np.float64] = self.mapped.trajectory.T_world_left
        return poses[0] if len(poses) else None

    @property
    def has_rays(self) -> bool:
        """True where the map knows what was looked through."""
        return "rays" in getattr(self.mapped.map, "channels", ())

    @property
    def states(self) -> GroundGrid | None:
        """Free, occupied and unknown floor cells: by the rays where the map keeps them, else by
        the ground of a recording; None where there is neither.
        """
        from recon.figures.free_ground import states_by_ground
        from recon.voxelmap.ground import navigation

        if self.has_rays:
            return navigation(self.mapped.voxels, self.mapped.map.sightings())
        return states_by_ground(self.mapped.voxels) if self.is_recorded else None


def _drawable(subject: Subject) -> str | None:
    return None


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """One kind of figure.

    A plug-in of the group `recon.figures` is one of these.
    """

    draw: Callable[[Subject, "Sheet"], Any]
    """Draws a subject on a sheet; returns the matplotlib Figure."""
    data: Callable[[Subject], Arrays]
    """The arrays that are drawn, by name."""
    size: tuple[int, int] = (1200, 900)
    """Pixels where nobody says."""
    has_view: bool = False
    """True where it is seen from somewhere."""
    is_kept: bool = False
    """True where it is drawn from arrays that the run kept, not from its map."""
    needs_mesh: bool = False
    """True where it shows the run's mesh."""
    lack: Callable[[Subject], str | None] = _drawable
    """The thing that a run with a map lacks for it; None where it can be drawn."""
