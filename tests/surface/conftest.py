"""The views beside the tests, importable, and a ball that they show."""

import sys
from pathlib import Path

import pytest

from recon.surface.volume import Volume

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session")
def ball():
    from views import VOXEL, ball_view, mesh_of

    volume = Volume(VOXEL)
    for angle in range(0, 360, 30):
        volume.add(ball_view(angle, noise=0.02, sigma=0.02))
    return mesh_of(volume)
