"""Renderers by name, which turn the triangles of a world into images."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from recon.plugins import Registry
from recon.settings.world import RenderSettings
from recon.world.solids import Triangles
from recon.world.visuals import Scene

if TYPE_CHECKING:
    from recon.world.render import Camera


class Renderer(Protocol):
    """A world that can be rendered."""

    def look(self, camera: "Camera") -> NDArray[np.uint8]:
        """The image (H, W, 3) RGB of a camera."""
        ...


BuildRenderer = Callable[[Scene, list[Triangles], tuple[int, int], RenderSettings], Renderer]
"""Called with a scene, the triangles of each visual, width and height, and the settings."""

RENDERERS: Registry[BuildRenderer] = Registry(
    "recon.renderers",
    "renderer",
    {
        "raycast": "recon.world.surfaces:build_raycaster",
        "filament": "recon.world.surfaces:build_filament",
    },
)
