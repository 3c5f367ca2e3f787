"""Small maps to draw figures of."""

import numpy as np
import pytest

from recon.records import FoundObject, Part, Sphere, Voxels


@pytest.fixture
def voxels():
    """A red column and a blue one, ten cells apart along x."""
    index = np.array([[x, y, 0] for x in (0, 10) for y in range(4)])
    colours = np.where(index[:, :1] == 0, [[220, 20, 20]], [[20, 20, 220]]).astype(np.uint8)
    return Voxels(
        index=index, centres=index + 0.5, means=index + 0.5, counts=np.full(8, 9),
        colours=colours, cell_size=1.0,
    )  # fmt: skip


@pytest.fixture
def no_voxels(voxels):
    return voxels.select(slice(0))


@pytest.fixture
def ball():
    """An object of one ball of radius 2 around (10.5, 2, 0.5)."""
    centre = np.array([10.5, 2.0, 0.5])
    part = Part(
        role="body", solid=Sphere(centre=centre, radius=2.0), hue_deg=None, num_voxels=4, rms=0.1
    )
    return FoundObject(
        id=3, label="pine tree", probability=0.9, centre=centre, size=np.full(3, 4.0),
        num_voxels=4, parts=(part,),
    )  # fmt: skip
