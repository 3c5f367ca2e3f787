"""A renderer: recon's own at night, with a quarter of the light."""

import recon
from recon.settings import RenderSettings
from recon.world.render import Camera
from recon.world.renderers import Renderer
from recon.world.solids import Triangles
from recon.world.surfaces import build_raycaster
from recon.world.visuals import Scene


class Night:
    """A renderer whose images are a quarter as bright."""

    def __init__(self, day: Renderer) -> None:
        self.day = day

    def look(self, camera: Camera) -> recon.Image:
        """The image of a camera."""
        return self.day.look(camera) // 4


def build(
    scene: Scene, parts: list[Triangles], size: tuple[int, int], settings: RenderSettings
) -> Night:
    """The renderer of a scene."""
    return Night(build_raycaster(scene, parts, size, settings))
