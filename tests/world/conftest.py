"""Worlds shared by the tests of this folder."""

from pathlib import Path

import pytest

from recon.settings.settings import Settings
from recon.settings.world import EyesSettings, RenderSettings, WorldSettings
from recon.world.visuals import Scene
from recon.world.world import World

SCENES = Path(__file__).parents[2] / "scenes"


@pytest.fixture(scope="session")
def village():
    return World.from_file(SCENES / "village.scene", Settings())


@pytest.fixture
def world_of():
    """Give a function that makes a world of visuals, with settings by stage."""

    def make(*visuals, textures=(), shaders=(), eyes=None, render=None, floor=None):
        return World(
            Scene(textures=textures, shaders=shaders, visuals=visuals),
            EyesSettings(**(eyes or {})),
            RenderSettings(**(render or {})),
            WorldSettings(**(floor or {})),
        )

    return make
