"""A scene's surfaces: their triangles and their look."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.settings.world import RenderSettings
from recon.world.filament import Filament
from recon.world.lighting import lit, painted
from recon.world.meshes import read_mesh
from recon.world.render import Look, Raycaster
from recon.world.solids import (
    Triangles,
    cylinder_triangles,
    lid_triangles,
    polygon_triangles,
    sphere_triangles,
)
from recon.world.textures import read_texture
from recon.world.visuals import (
    NONE,
    CylinderVisual,
    MeshVisual,
    PolygonVisual,
    Scene,
    Shader,
    Visual,
)


def visual_triangles(visual: Visual, folder: Path | None, tile: float) -> Triangles:
    """The triangles of any visual of a scene in `folder`; a texture covers `tile` world units."""
    if isinstance(visual, CylinderVisual):
        triangles = cylinder_triangles(visual, tile)
    elif isinstance(visual, PolygonVisual):
        triangles = polygon_triangles(visual)
    elif isinstance(visual, MeshVisual):
        triangles = read_mesh((folder or Path()) / visual.file)
    else:
        triangles = sphere_triangles(visual, tile)
    return triangles.without_slivers()


def lids(scene: Scene) -> list[Triangles]:
    """Lids that close the ends of a scene's open cylinders."""
    cylinders = (visual for visual in scene.visuals if isinstance(visual, CylinderVisual))
    return [lid.without_slivers() for visual in cylinders for lid in lid_triangles(visual)]


def build_raycaster(
    scene: Scene, parts: list[Triangles], size: tuple[int, int], settings: RenderSettings
) -> Raycaster:
    """The renderer of a scene, for images of any size."""
    if settings.shading:
        parts = [lit(part, shader) for part, shader in zip(parts, _shaders(scene), strict=True)]
    return Raycaster(parts, *_looks(scene), settings)


def build_filament(
    scene: Scene, parts: list[Triangles], size: tuple[int, int], settings: RenderSettings
) -> Filament:
    """The renderer with light and shadows, for images of one size."""
    if settings.shading:
        parts = [painted(part, shader) for part, shader in zip(parts, _shaders(scene), strict=True)]
    return Filament(parts, *_looks(scene), size, settings)


def _shaders(scene: Scene) -> list[Shader | None]:
    return [None if v.shader == NONE else scene.shaders[v.shader] for v in scene.visuals]


def _looks(scene: Scene) -> tuple[list[Look], list[NDArray[np.uint8]]]:
    """The look of each visual, and the textures that any of them uses."""
    names = [scene.texture_of(visual) for visual in scene.visuals]
    used = sorted({name for name in names if name is not None})
    looks = [
        Look(
            texture=NONE if name is None else used.index(name),
            one_sided=isinstance(visual, PolygonVisual) and visual.cull_back,
        )
        for name, visual in zip(names, scene.visuals, strict=True)
    ]
    return looks, [read_texture(name, scene.folder) for name in used]
