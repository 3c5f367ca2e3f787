"""The simulator: a scene, two eyes, and everything that is true in it."""

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.camera import StereoRig
from recon.errors import InputError, check_finite, check_shape
from recon.geometry import Array
from recon.records import StereoPair, View
from recon.settings.settings import Settings
from recon.settings.world import EyesSettings, RenderSettings, WorldSettings
from recon.world.eyes import Eye, eye_of, eyes_of, left_pose, rectified, rig_of
from recon.world.frames import export_frame
from recon.world.library import find_scene
from recon.world.objects import TrueObject, is_ground, true_objects
from recon.world.panes import front_camera, top_camera
from recon.world.rays import RayScene
from recon.world.scene import read_scene
from recon.world.sensor import exposed
from recon.world.solids import contains
from recon.world.surfaces import build_filament, build_raycaster, lids, visual_triangles
from recon.world.visuals import Scene

START_DISTANCE = 10.0
"""How far ahead the agent looks at first, world units."""

MAX_GROUND_CELLS = 100_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Truth:
    """What is really there, for each pixel of a view's LEFT image."""

    depth: Array
    """(H, W) along z of the left camera, world units; NaN = nothing."""
    object_id: NDArray[np.int32]
    """(H, W) number in `World.objects`, -1 = ground or sky."""
    part_id: NDArray[np.int32]
    """(H, W) number of the visual in the scene, -1 = ground or sky."""


class World:
    """A simulated world that can be looked at from anywhere.

    Parameters
    ----------
    scene : what stands in it
    eyes, render, world : settings of the eyes, the renderer and the floor

    Raises
    ------
    InputError
        For a texture or a mesh that is nowhere or cannot be read.
    """

    def __init__(
        self, scene: Scene, eyes: EyesSettings, render: RenderSettings, world: WorldSettings
    ) -> None:
        self.scene = scene
        self.eyes = eyes
        self.render = render
        self.floor = world
        parts = [visual_triangles(visual, scene.folder) for visual in scene.visuals]
        solid = [p for v, p in zip(scene.visuals, parts, strict=True) if not is_ground(v, p)]
        self._caster = build_raycaster(scene, parts, render)
        self._renderer = (
            build_filament(scene, parts, (eyes.width, eyes.height), render)
            if render.renderer == "filament"
            else self._caster
        )
        self._solids, self._surfaces = RayScene(solid), RayScene(parts)
        self._closed = RayScene([*solid, *lids(scene)])
        self.objects: tuple[TrueObject, ...] = true_objects(scene.visuals, parts)
        # One longer than the visuals, so that number -1, the sky, reads -1 too.
        self._object_of = np.full(len(parts) + 1, -1, np.int32)
        for found in self.objects:
            self._object_of[list(found.visuals)] = found.id

    @classmethod
    def from_file(cls, path: str | Path, settings: Settings | None = None) -> "World":
        """The world of a geometry file, or of a scene that ships, by its name."""
        chosen = settings or Settings()
        return cls(read_scene(find_scene(path)), chosen.eyes, chosen.render, chosen.world)

    def start(self) -> View:
        """Where the agent begins: the middle of the floor, looking along -z."""
        height = self.eyes.eye_height
        return View(
            position=np.array([0.0, height, 0.0]),
            target=np.array([0.0, height, -START_DISTANCE]),
        )

    def take(self, view: View) -> StereoPair:
        """What both eyes see, rectified; the same view gives the same bytes.

        Raises
        ------
        InputError
            Where the view is not finite, looks straight up or down, or has unusable parameters.
        """
        rig, T_world_left, eyes = self._stand(view)
        left = self._see(eye_of(T_world_left, rig, rig.cx_left_px, eyes))
        T_world_right = T_world_left @ rig.T_left_right
        right = self._see(eye_of(T_world_right, rig, rig.cx_right_px, eyes))
        return StereoPair(left=left, right=right, rig=rig, T_world_left=T_world_left)

    def truth(self, view: View) -> Truth:
        """What is really there in the left image of `take(view)`."""
        rig, T_world_left, eyes = self._stand(view)
        straight = dataclasses.replace(eyes, gaze="shift")
        eye = eye_of(T_world_left, rig, rig.cx_left_px, straight)
        depth, visual = self._caster.measure(eye.camera)
        object_id = self._object_of[visual]
        return Truth(
            depth=depth,
            object_id=object_id,
            part_id=np.where(object_id < 0, np.int32(-1), visual),
        )

    def _stand(self, view: View) -> tuple[StereoRig, Array, EyesSettings]:
        eyes = eyes_of(view, self.eyes)
        T_world_left = left_pose(view, eyes.baseline)
        return rig_of(view, eyes), T_world_left, eyes

    def _see(self, eye: Eye) -> NDArray[np.uint8]:
        image = self._renderer.look(eye.camera)
        return rectified(exposed(image, eye.camera.frame, self.render), eye.H_rectified_eye)

    def top_view(self, size: int = 512) -> NDArray[np.uint8]:
        """The floor from above (H, W, 3): x to the right, z down, the longer side `size` pixels."""
        return self._caster.look(top_camera(self.floor, size))

    def front_view(self, size: int = 512) -> NDArray[np.uint8]:
        """The world from its front (H, W, 3), along -z: x to the right over `size` pixels, y up."""
        return self._caster.look(front_camera(self.floor, size))

    def export_frame(self, view: View, folder: str | Path) -> None:
        """Write a view's images, true disparity and calibration to a folder."""
        export_frame(self.take(view), self.truth(view).depth, folder)

    def clearance(self, positions: ArrayLike) -> Array:
        """(N,) distance of points (N, 3) to the nearest object's surface, ground excluded.

        Also inside an object this is the distance to its surface: `is_inside` tells them apart.
        """
        return self._solids.distance(_points("positions", positions))

    def surface_distance(self, points_world: ArrayLike) -> Array:
        """(N,) distance of points (N, 3) to the nearest surface, ground included."""
        return self._surfaces.distance(_points("points_world", points_world))

    def is_inside(self, positions: ArrayLike) -> NDArray[np.bool_]:
        """(N,) whether points (N, 3) lie inside one of the thesis's solids."""
        points = _points("positions", positions)
        inside = np.zeros(len(points), bool)
        for visual in self.scene.visuals:
            inside |= contains(visual, points)
        return inside

    def free_ground(self) -> NDArray[np.bool_]:
        """(X, Z) cells of one unit of the floor whose middle no object stands on or hangs over.

        Cell (i, j) begins at x = i - size_x / 2, z = j - size_z / 2.

        Raises
        ------
        InputError
            Where the floor has more cells than fit into memory.
        """
        size = np.array([self.floor.size_x, self.floor.size_z])
        num_x, num_z = np.ceil(size).astype(np.int64).tolist()
        if num_x * num_z > MAX_GROUND_CELLS:
            raise InputError(
                f"the floor is {num_x} x {num_z} units, but at most {MAX_GROUND_CELLS} square "
                "units can be mapped: make world.size_x and world.size_z smaller"
            )
        index = np.stack(np.meshgrid(np.arange(num_x), np.arange(num_z), indexing="ij"), axis=-1)
        covered = self._closed.covers(index.reshape(-1, 2) + 0.5 - size / 2)
        return ~covered.reshape(num_x, num_z)


def _points(name: str, points: ArrayLike) -> Array:
    array = np.asarray(points, dtype=np.float64)
    check_shape(name, array, (None, 3))
    check_finite(name, array)
    return array
