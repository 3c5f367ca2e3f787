"""The simulator: a scene, two cameras and the ground truth."""

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.camera import StereoRig
from recon.errors import InputError, check_finite, check_shape, check_type
from recon.geometry import Array
from recon.records import Mesh, StereoPair, View
from recon.settings.settings import Settings
from recon.settings.world import EyesSettings, RenderSettings, WorldSettings
from recon.world.body import BodyRoom
from recon.world.cameras import (
    RectifiedCamera,
    camera_of,
    camera_settings,
    left_pose,
    rectified,
    rig_of,
)
from recon.world.frames import export_frame
from recon.world.library import find_scene
from recon.world.objects import TrueObject, is_ground, true_objects
from recon.world.panes import front_camera, top_camera
from recon.world.rays import RayScene
from recon.world.renderers import RENDERERS, Renderer
from recon.world.scene import read_scene
from recon.world.sensor import exposed
from recon.world.solids import contains
from recon.world.start import first_view
from recon.world.surfaces import build_raycaster, lids, visual_triangles
from recon.world.visuals import MeshVisual, PolygonVisual, Scene

MAX_GROUND_CELLS = 100_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Truth:
    """The ground truth for each pixel of a view's LEFT image."""

    depth: Array
    """(H, W) along z of the left camera, world units; NaN = nothing."""
    object_id: NDArray[np.int32]
    """(H, W) number in `World.objects`, -1 = ground or sky."""
    part_id: NDArray[np.int32]
    """(H, W) number of the visual in the scene, -1 = ground or sky."""


class World:
    """A simulated world that can be viewed from anywhere.

    Parameters
    ----------
    scene : Scene
    eyes : EyesSettings
    render : RenderSettings
    world : WorldSettings
        Of the floor.

    Raises
    ------
    InputError
        For a texture or a mesh that is missing or cannot be read.
    """

    def __init__(
        self, scene: Scene, eyes: EyesSettings, render: RenderSettings, world: WorldSettings
    ) -> None:
        self.scene = scene
        self.eyes = eyes
        self.render = render
        self.floor = world
        tile, size = render.texture_tile, (eyes.width, eyes.height)
        parts = [visual_triangles(visual, scene.folder, tile) for visual in scene.visuals]
        self._caster = build_raycaster(scene, parts, size, render)
        is_own = render.renderer == "raycast"
        self._renderer: Renderer = (
            self._caster if is_own else RENDERERS.load(render.renderer)(scene, parts, size, render)
        )
        self._parts = {
            visual: part
            for visual, part in zip(scene.visuals, parts, strict=True)
            if not is_ground(visual, part, eyes.eye_height)
        }
        solid = list(self._parts.values())
        self._solids, self._surfaces = RayScene(solid), RayScene(parts)
        self._corners = np.concatenate([np.empty((0, 3, 3)), *(part.corners for part in parts)])
        self._closed = RayScene([*solid, *lids(scene)])
        self._rooms: dict[float, BodyRoom] = {}
        self.objects: tuple[TrueObject, ...] = true_objects(scene.visuals, parts, eyes.eye_height)
        # One longer than the visuals, so that index -1, the sky, maps to -1.
        self._object_of = np.full(len(parts) + 1, -1, np.int32)
        for found in self.objects:
            self._object_of[list(found.visuals)] = found.id

    @classmethod
    def from_file(cls, path: str | Path, settings: Settings | None = None) -> "World":
        """The world of a geometry file, or of a scene that ships, by its name."""
        chosen = settings or Settings()
        return cls(read_scene(find_scene(path)), chosen.eyes, chosen.render, chosen.world)

    def start(self) -> View:
        """The first view: the middle of the floor, looking along -z."""
        return first_view(self.eyes)

    def take(self, view: View) -> StereoPair:
        """The images of both cameras, rectified; the same view gives the same bytes.

        Raises
        ------
        InputError
            If the view is not finite, looks straight up or down, or has unusable parameters.
        """
        check_type("view", view, View)
        rig, T_world_left, eyes = self._stand(view)
        left = self._see(camera_of(T_world_left, rig, rig.cx_left_px, eyes))
        T_world_right = T_world_left @ rig.T_left_right
        right = self._see(
            camera_of(T_world_right, rig, rig.cx_right_px, eyes),
            gain=self.render.gain_right,
            offset=self.render.offset_right,
        )
        return StereoPair(left=left, right=right, rig=rig, T_world_left=T_world_left)

    def truth(self, view: View) -> Truth:
        """The ground truth of the left image of `take(view)`."""
        rig, T_world_left, eyes = self._stand(view)
        straight = dataclasses.replace(eyes, gaze="shift")
        at = camera_of(T_world_left, rig, rig.cx_left_px, straight)
        depth, visual = self._caster.measure(at.camera)
        object_id = self._object_of[visual]
        return Truth(
            depth=depth,
            object_id=object_id,
            part_id=np.where(object_id < 0, np.int32(-1), visual),
        )

    def _stand(self, view: View) -> tuple[StereoRig, Array, EyesSettings]:
        eyes = camera_settings(view, self.eyes)
        T_world_left = left_pose(view, eyes.baseline)
        return rig_of(view, eyes), T_world_left, eyes

    def _see(
        self, at: RectifiedCamera, *, gain: float = 1.0, offset: float = 0.0
    ) -> NDArray[np.uint8]:
        image = self._renderer.look(at.camera)
        taken = exposed(image, at.camera.frame, self.render, gain=gain, offset=offset)
        return rectified(taken, at.H_rectified_camera)

    @property
    def box(self) -> tuple[Array, Array]:
        """Lowest and highest corner (3,) of the objects; of everything if there are none."""
        standing = [part.corners.reshape(-1, 3) for part in self._parts.values()]
        points = np.concatenate(standing) if standing else self._corners.reshape(-1, 3)
        return points.min(axis=0), points.max(axis=0)

    @property
    def mesh(self) -> Mesh:
        """Every surface of the world, ground included."""
        vertices, number = np.unique(self._corners.reshape(-1, 3), axis=0, return_inverse=True)
        return Mesh(vertices=vertices, triangles=number.reshape(-1, 3).astype(np.int32))

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

        Inside an object, too, this is the distance to its surface: see `is_inside`.
        """
        return self._solids.distance(_points("positions", positions))

    def body_clearance(self, places_xz: ArrayLike, height: float) -> Array:
        """(N,) distance of upright axes at x, z (N, 2) to the nearest surface, ground excluded.

        The axes extend from the ground to `height`, like that of a body.
        """
        places = np.asarray(places_xz, dtype=np.float64)
        check_shape("places_xz", places, (None, 2))
        check_finite("places_xz", places)
        if height not in self._rooms:
            self._rooms[height] = BodyRoom(list(self._parts.values()), height)
        return self._rooms[height].clearance(places)

    def surface_distance(self, points_world: ArrayLike) -> Array:
        """(N,) distance of points (N, 3) to the nearest surface, ground included."""
        return self._surfaces.distance(_points("points_world", points_world))

    def is_inside(self, positions: ArrayLike) -> NDArray[np.bool_]:
        """(N,) mask of the points (N, 3) inside a solid, a mesh, or walls of polygons."""
        points = _points("positions", positions)
        walls = [p for v, p in self._parts.items() if isinstance(v, PolygonVisual | MeshVisual)]
        inside = RayScene(walls).encloses(points)
        for visual in self._parts:
            inside |= contains(visual, points)
        return inside

    def free_ground(self, cell_size: float = 1.0) -> NDArray[np.bool_]:
        """(X, Z) mask of the floor cells whose centre no object stands on or hangs over.

        Cell (i, j) begins at x = i cell_size - size_x / 2, z = j cell_size - size_z / 2.

        Raises
        ------
        InputError
            If the floor has more cells than fit into memory.
        """
        size = np.array([self.floor.size_x, self.floor.size_z])
        num_x, num_z = np.ceil(size / cell_size - 1e-9).astype(np.int64).tolist()
        if num_x * num_z > MAX_GROUND_CELLS:
            raise InputError(
                f"the floor is {num_x} x {num_z} cells, but at most {MAX_GROUND_CELLS} can be "
                "mapped: make world.size_x and world.size_z smaller"
            )
        index = np.stack(np.meshgrid(np.arange(num_x), np.arange(num_z), indexing="ij"), axis=-1)
        covered = self._closed.covers((index.reshape(-1, 2) + 0.5) * cell_size - size / 2)
        return ~covered.reshape(num_x, num_z)


def _points(name: str, points: ArrayLike) -> Array:
    array = np.asarray(points, dtype=np.float64)
    check_shape(name, array, (None, 3))
    check_finite(name, array)
    return array
