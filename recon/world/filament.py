"""Images by Open3D's rasteriser Filament, which has lighting and shadows but needs Vulkan."""

import contextlib
import ctypes
import functools
import itertools
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, MissingLibraryError
from recon.geometry import Array, pose
from recon.libraries import load_open3d
from recon.settings.world import RenderSettings
from recon.world.lighting import SUN
from recon.world.render import SKY_RGB, Camera, Look, backdrop, pixel_offsets, pixels
from recon.world.sampling import skies
from recon.world.solids import Triangles
from recon.world.visuals import NONE

APT_LINE = "apt-get install -y --no-install-recommends libvulkan1 mesa-vulkan-drivers"

# Chosen so that open ground keeps nine tenths of its colour, and a shadow half of that.
SUN_LUX = 64_000.0
AMBIENT_LUX = 17_000.0

# Without Vulkan, creating a renderer raises or kills the process, so try it in a child.
_PROBE = """
from recon.libraries import load_open3d
renderer = load_open3d().visualization.rendering.OffscreenRenderer(32, 32)
renderer.render_to_image()
"""


@functools.cache
def filament_fault() -> str | None:
    """The reason why Filament cannot draw here, with a remedy; None if it can."""
    result = subprocess.run(
        [sys.executable, "-c", _PROBE], capture_output=True, text=True, check=False
    )
    if result.returncode == 0:
        return None
    said = result.stderr.strip().splitlines() or [f"exit {result.returncode}"]
    return (
        f"the filament renderer does not work ({said[-1]}); run: {APT_LINE}, or use the renderer "
        "raycast"
    )


_NUMBERS = itertools.count()


class Filament:
    """All triangles of a world, drawn by Filament on one shared stage.

    Parameters
    ----------
    parts : sequence of Triangles
        Of each visual.
    looks : sequence of Look
        Of each visual.
    images : sequence of (H, W, 3) uint8
        Textures.
    size : (width, height)
        Of its images, pixels.
    settings : RenderSettings

    Raises
    ------
    MissingLibraryError
        If Filament cannot draw, with the command that fixes it.
    InputError
        If this process has drawn images of another size.
    """

    def __init__(
        self,
        parts: Sequence[Triangles],
        looks: Sequence[Look],
        images: Sequence[NDArray[np.uint8]],
        size: tuple[int, int],
        settings: RenderSettings,
    ) -> None:
        self._stage = _stage(*size)
        self._side = settings.supersampling
        self._backdrop = backdrop(settings)
        self._name = f"world {next(_NUMBERS)}"
        self._visuals = [
            (_mesh(part), _material(look, images, settings.shading))
            for part, look in zip(parts, looks, strict=True)
            if len(part.corners)
        ]

    def look(self, camera: Camera) -> NDArray[np.uint8]:
        """The image (H, W, 3) of a perspective camera, supersampled everywhere."""
        samples = [self._sample(camera, offset)[0] for offset in pixel_offsets(self._side)]
        image: NDArray[np.uint8] = np.rint(np.mean(samples, axis=0)).astype(np.uint8)
        return image

    def depth(self, camera: Camera) -> Array:
        """Depth (H, W) along z at the centre of each pixel, NaN = nothing."""
        return self._sample(camera, np.zeros(2))[1]

    def _sample(self, camera: Camera, offset_px: Array) -> tuple[Array, Array]:
        """Colour (H, W, 3), 0 to 255, and depth (H, W), at an offset (2,) from each pixel centre.

        Filament counts pixels from their corner, not their centre, and has no far plane.
        """
        self._enter()
        T_world_camera, K = _pose_and_intrinsics(camera.frame)
        K[:2, 2] += 0.5 - offset_px
        size = (camera.width, camera.height)
        with _quiet_stdout():
            self._stage.setup_camera(K, np.linalg.inv(T_world_camera), *size)
            self._stage.scene.camera.set_projection(K, camera.near, camera.far, *size)
            rgb = np.asarray(self._stage.render_to_image(), dtype=np.float64)
            z = np.asarray(self._stage.render_to_depth_image(True), dtype=np.float64)
        sky = skies(camera.frame, pixels(camera) + offset_px, self._backdrop).reshape(rgb.shape)
        depth = np.where(z <= camera.far, z, np.nan)
        clear = np.nan_to_num(np.exp(-self._backdrop[2] * depth))[..., None]
        return clear * rgb + (1.0 - clear) * sky, depth

    def _enter(self) -> None:
        """Put this world on the stage if another one is there."""
        scene = self._stage.scene
        names = [f"{self._name} visual {number}" for number in range(len(self._visuals))]
        if not (names and scene.has_geometry(names[0])):
            scene.clear_geometry()
            for name, visual in zip(names, self._visuals, strict=True):
                scene.add_geometry(name, *visual)


@functools.cache
def _stage(width: int, height: int) -> Any:
    """The only renderer of this process: with two, Filament crashes at exit."""
    fault = filament_fault()
    if fault:
        raise MissingLibraryError(fault)
    if _stage.cache_info().currsize:
        raise InputError(
            f"cameras of {width} x {height} pixels: the filament renderer draws one size per "
            "process, and has drawn another; restart or use the renderer raycast"
        )
    with _quiet_stdout():
        stage = load_open3d().visualization.rendering.OffscreenRenderer(width, height)
    stage.scene.set_background([*(_encoded(np.array(SKY_RGB)) / 255.0), 1.0])
    # Tone mapping and dithering would change the colours, and not reproducibly.
    stage.scene.view.set_post_processing(False)
    light = stage.scene.scene
    light.enable_sun_light(True)
    light.set_sun_light(-SUN.astype(np.float32), np.ones(3, np.float32), SUN_LUX)
    light.enable_indirect_light(True)
    light.set_indirect_light_intensity(AMBIENT_LUX)
    return stage


def _pose_and_intrinsics(frame: Array) -> tuple[Array, Array]:
    """`T_world_camera` (4, 4) and the camera matrix (3, 3) of a perspective camera's frame."""
    focal_px = 1.0 / np.linalg.norm(frame[3])
    right, down = frame[3] * focal_px, frame[5] * focal_px
    cx_px, cy_px = -focal_px * (right @ frame[1]), -focal_px * (down @ frame[1])
    K = np.array([[focal_px, 0.0, cx_px], [0.0, focal_px, cy_px], [0.0, 0.0, 1.0]])
    return pose(np.column_stack([right, down, np.cross(right, down)]), frame[0]), K


def _mesh(part: Triangles) -> Any:
    o3d = load_open3d()
    count = 3 * len(part.corners)
    vector = o3d.utility.Vector3dVector
    mesh = o3d.geometry.TriangleMesh(
        vector(part.corners.reshape(-1, 3)),
        o3d.utility.Vector3iVector(np.arange(count, dtype=np.int32).reshape(-1, 3)),
    )
    mesh.vertex_normals = vector(part.normals.reshape(-1, 3))
    mesh.vertex_colors = vector(part.colours.reshape(-1, 3))
    # Open3D counts v upwards.
    mesh.triangle_uvs = o3d.utility.Vector2dVector(part.uv.reshape(-1, 2) * (1.0, -1.0))
    return mesh


def _material(look: Look, images: Sequence[NDArray[np.uint8]], shading: bool) -> Any:
    o3d = load_open3d()
    material = o3d.visualization.rendering.MaterialRecord()
    material.shader = "defaultLit" if shading else "defaultUnlit"
    if look.texture != NONE:
        material.albedo_img = o3d.geometry.Image(_encoded(images[look.texture]))
    return material


def _encoded(colour: NDArray[np.uint8] | Array) -> NDArray[np.uint8]:
    """Colours, 0 to 255, encoded as sRGB, which Filament decodes again."""
    share = colour / 255.0
    srgb = np.where(share <= 0.0031308, 12.92 * share, 1.055 * share ** (1 / 2.4) - 0.055)
    return np.rint(255.0 * srgb).astype(np.uint8)


@contextlib.contextmanager
def _quiet_stdout() -> Iterator[None]:
    """Redirect the library's output to stderr: stdout belongs to the command."""
    library = ctypes.CDLL(None)
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
        library.fflush(None)
    finally:
        os.dup2(kept, 1)
        os.close(kept)
