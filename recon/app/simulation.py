"""The simulated cameras of one visitor: poses, images and matches."""

import threading
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from recon.app.channels import Points, points_of
from recon.errors import InputError
from recon.records import FoundObject, StereoPair, View
from recon.settings import Settings, explorers, updated
from recon.world.start import first_view

if TYPE_CHECKING:
    from recon.world.world import World

Array = NDArray[np.float64]

CAMERA = ("focal_length", "fov_deg", "baseline", "near", "far")
PLACES = ("x", "y", "z", "target_x", "target_y", "target_z")
MAP_PX = 512
"""Longer side of the map panes."""
ROUND = 4
"""Decimal digits of dragged positions."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sight:
    """The current images of both cameras."""

    pair: StereoPair
    points: Points | None
    """Matched points, if requested."""


class Simulation:
    """A world and its cameras; invalid values are refused and change nothing."""

    def __init__(self, scene: Path, settings: Settings | None = None) -> None:
        self.scene = scene
        self.settings = settings or explorers(Settings())
        start = first_view(self.settings.eyes)
        self.position, self.target = start.position, start.target
        self.objects: tuple[FoundObject, ...] = ()
        self._world: World | None = None
        self._lock = threading.RLock()

    @property
    def world(self) -> "World":
        """The world, created when first looked at, so that the page does not wait for it."""
        with self._lock:
            if self._world is None:
                self._world = self._made(self.settings)
            return self._world

    @property
    def view(self) -> View:
        """Position, target and parameters of the cameras."""
        eyes = self.settings.eyes
        return View(
            position=self.position, target=self.target, fov_deg=eyes.fov_deg,
            baseline=eyes.baseline, near=eyes.near, far=eyes.far,
        )  # fmt: skip

    def values(self) -> dict[str, float]:
        """All fields of the camera settings."""
        places = dict(zip(PLACES, [*self.position, *self.target], strict=True))
        eyes = self.settings.eyes
        numbers = {name: float(getattr(eyes, name)) for name in CAMERA}
        sizes = {"width": float(eyes.width), "height": float(eyes.height)}
        return {name: float(value) for name, value in (places | numbers | sizes).items()}

    def change(self, name: str, value: float | None) -> None:
        """Change one field of the camera settings.

        Raises
        ------
        InputError
            For an invalid value; everything stays unchanged.
        """
        if value is None or not np.isfinite(value):
            raise InputError(f"{name} is {value}, but a number is needed")
        if name in PLACES:
            at = PLACES.index(name)
            place = np.array([*self.position, *self.target])
            place[at] = value
            self.move(place[:3], place[3:])
        else:
            whole = name in ("width", "height")
            self.change_settings({"eyes": {name: int(value) if whole else value}})

    def move(self, position: Array, target: Array) -> None:
        """Move the cameras and their target.

        Raises
        ------
        InputError
            If they are outside the world, or define no direction.
        """
        floor = self.settings.world
        half_x, half_z = floor.size_x / 2.0, floor.size_z / 2.0
        low, high = np.array([-half_x, 0.0, -half_z]), np.array([half_x, floor.height, half_z])
        for called, place in (("camera", position), ("target", target)):
            for axis, number in enumerate(place.tolist()):
                if not low[axis] <= number <= high[axis]:
                    raise InputError(
                        f"{called} {'xyz'[axis]} is {number:g}, but {low[axis]:g} to "
                        f"{high[axis]:g} is needed: the world ends there"
                    )
        offset = target - position
        if np.hypot(offset[0], offset[2]) < 1e-6:
            raise InputError("the target is straight above or below the camera; move it aside")
        self.position, self.target = np.round(position, ROUND), np.round(target, ROUND)

    def change_settings(self, changes: dict[str, dict[str, Any]]) -> None:
        """Change settings; the world is rebuilt if its look changes.

        Raises
        ------
        InputError
            For an invalid value; everything stays unchanged.
        """
        chosen = updated(self.settings, changes)
        if _makes_anew(self.settings, chosen):
            world = self._made(chosen)
            with self._lock:
                self._world = world
        self.settings = chosen

    def look(self, *, with_points: bool) -> Sight:
        """The images of both cameras, with their matched points if requested."""
        with self._lock:
            pair = self.world.take(self.view)
        if not with_points:
            return Sight(pair=pair, points=None)
        # Late: the first image need not wait for the matching libraries.
        from recon.mapping.sparse import match_features
        from recon.stereo.features import detect

        settings = self.settings
        left, right = (detect(side, settings.features) for side in (pair.left, pair.right))
        matches = match_features(left, right, settings, pair.disparity_range, pair.rig.residual_px)
        points = points_of(pair, matches, left, self.objects, settings.map.cell_size)
        return Sight(pair=pair, points=points)

    def maps(self) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """The world from above and from the front."""
        with self._lock:
            return self.world.top_view(MAP_PX), self.world.front_view(MAP_PX)

    def _made(self, settings: Settings) -> "World":
        # Late: it loads what renders.
        from recon.world.world import World

        return World.from_file(self.scene, settings)


def _makes_anew(old: Settings, new: Settings) -> bool:
    sizes = ("width", "height", "eye_height", "gaze")
    eyes = any(getattr(old.eyes, name) != getattr(new.eyes, name) for name in sizes)
    render = any(
        getattr(old.render, one.name) != getattr(new.render, one.name) for one in fields(old.render)
    )
    world = any(
        getattr(old.world, one.name) != getattr(new.world, one.name) for one in fields(old.world)
    )
    return eyes or render or world
