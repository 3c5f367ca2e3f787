"""The simulator: a scene, two eyes, and everything that is true in it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError, check_shape
from recon.geometry import Array
from recon.libraries import load_open3d
from recon.records import StereoPair, View
from recon.settings.settings import Settings
from recon.settings.world import EyesSettings, RenderSettings, WorldSettings
from recon.world.eyes import eye_camera, eyes_of, left_pose, rig_of
from recon.world.meshes import read_mesh
from recon.world.objects import TrueObject, is_ground, true_objects
from recon.world.render import Raycaster, cast_scene, first_hit
from recon.world.scene import read_scene
from recon.world.solids import (
    Triangles,
    cylinder_triangles,
    polygon_triangles,
    sphere_triangles,
)
from recon.world.textures import build_atlas, read_texture
from recon.world.visuals import (
    CylinderVisual,
    MeshVisual,
    PolygonVisual,
    Scene,
    Visual,
)

START_DISTANCE = 10.0
"""How far ahead the agent looks at first, world units."""

MAX_GROUND_CELLS = 100_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Truth:
    """What is really there, for each pixel of a view's LEFT picture."""

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
        self.settings = world
        parts = [visual_triangles(visual, scene.folder) for visual in scene.visuals]
        self._caster = _raycaster(scene, parts, render)
        self.objects: tuple[TrueObject, ...] = true_objects(scene.visuals, parts)
        solid = [
            part
            for visual, part in zip(scene.visuals, parts, strict=True)
            if not is_ground(visual, part)
        ]
        self._solids = cast_scene(solid)
        self._surfaces = cast_scene(parts)
        # One longer than the visuals, so that number -1, the sky, reads -1 too.
        self._object_of = np.full(len(parts) + 1, -1, np.int32)
        for found in self.objects:
            self._object_of[list(found.visuals)] = found.id

    @classmethod
    def from_file(cls, path: str | Path, settings: Settings) -> "World":
        """The world of a geometry file."""
        return cls(read_scene(path), settings.eyes, settings.render, settings.world)

    def start(self) -> View:
        """Where the agent begins: the middle of the floor, looking along -z."""
        height = self.eyes.eye_height
        return View(
            position=np.array([0.0, height, 0.0]),
            target=np.array([0.0, height, -START_DISTANCE]),
        )

    def take(self, view: View) -> StereoPair:
        """What both eyes see, rectified.

        Raises
        ------
        InputError
            Where the view is not finite, looks straight up or down, or has unusable parameters.
        """
        eyes = eyes_of(view, self.eyes)
        rig = rig_of(view, eyes)
        T_world_left = left_pose(view, eyes.baseline)
        left, right = (
            self._caster.look(eye_camera(T, rig.focal_px, np.array([cx_px, rig.cy_px]), eyes)).rgb
            for T, cx_px in (
                (T_world_left, rig.cx_left_px),
                (T_world_left @ rig.T_left_right, rig.cx_right_px),
            )
        )
        return StereoPair(left=left, right=right, rig=rig, T_world_left=T_world_left)

    def truth(self, view: View) -> Truth:
        """What is really there in the left picture of `take(view)`."""
        eyes = eyes_of(view, self.eyes)
        rig = rig_of(view, eyes)
        camera = eye_camera(
            left_pose(view, eyes.baseline),
            rig.focal_px,
            np.array([rig.cx_left_px, rig.cy_px]),
            eyes,
        )
        picture = self._caster.look(camera)
        object_id = self._object_of[picture.visual]
        return Truth(
            depth=picture.depth,
            object_id=object_id,
            part_id=np.where(object_id < 0, np.int32(-1), picture.visual),
        )

    def clearance(self, positions: ArrayLike) -> Array:
        """(N,) distance of points (N, 3) to the nearest object's surface; ground is none."""
        return _distance(self._solids, positions)

    def surface_distance(self, points_world: ArrayLike) -> Array:
        """(N,) distance of points (N, 3) to the nearest surface, ground included."""
        return _distance(self._surfaces, points_world)

    def free_ground(self) -> NDArray[np.bool_]:
        """(X, Z) cells of one unit of the floor whose middle no object stands on or hangs over.

        Cell (i, j) reaches from x = i - size_x / 2 and z = j - size_z / 2 on, one unit each.
        """
        num_x, num_z = (int(np.ceil(size)) for size in (self.settings.size_x, self.settings.size_z))
        if num_x * num_z > MAX_GROUND_CELLS:
            raise InputError(
                f"the floor has {num_x} x {num_z} cells, but at most {MAX_GROUND_CELLS} fit"
            )
        x, z = np.meshgrid(np.arange(num_x) + 0.5, np.arange(num_z) + 0.5, indexing="ij")
        below = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
        below -= (self.settings.size_x / 2, 0, self.settings.size_z / 2)
        top = max((found.centre[1] + found.size[1] for found in self.objects), default=0.0) + 1.0
        up, down = np.array([0.0, top, 0.0]), np.array([0.0, -1.0, 0.0])
        hit = first_hit(self._solids, below + up, np.tile(down, (x.size, 1)), 0.0, np.inf)
        free: NDArray[np.bool_] = (hit < 0).reshape(x.shape)
        return free


def visual_triangles(visual: Visual, folder: Path | None) -> Triangles:
    """The triangles of any visual of a scene in `folder`."""
    if isinstance(visual, CylinderVisual):
        triangles = cylinder_triangles(visual)
    elif isinstance(visual, PolygonVisual):
        triangles = polygon_triangles(visual)
    elif isinstance(visual, MeshVisual):
        triangles = read_mesh((folder or Path()) / visual.file)
    else:
        triangles = sphere_triangles(visual)
    return triangles.without_slivers()


def _raycaster(scene: Scene, parts: list[Triangles], render: RenderSettings) -> Raycaster:
    """The renderer, with each texture that a visual uses read once."""
    names = [scene.texture_of(visual) for visual in scene.visuals]
    used = sorted({name for name in names if name is not None})
    atlas = build_atlas([read_texture(name, scene.folder) for name in used], render.mipmaps)
    return Raycaster(parts, [-1 if n is None else used.index(n) for n in names], atlas, render)


def _distance(scene: Any, points: ArrayLike) -> Array:
    array = np.asarray(points, dtype=np.float64)
    check_shape("points", array, (None, 3))
    if scene is None:
        return np.full(len(array), np.inf)
    o3d = load_open3d()
    query = o3d.core.Tensor.from_numpy(array.astype(np.float32))
    distance: Array = scene.compute_distance(query).numpy().astype(np.float64)
    return distance
