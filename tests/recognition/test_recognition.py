"""Objects of a map get the right name, place and size."""

import numpy as np
import pytest

from recon.recognition import components, recognise
from recon.recognition.synthetic import Orbit, observe, random_stack, voxelise
from recon.records import Voxels
from recon.settings import RecognitionSettings

SETTINGS = RecognitionSettings()
NEAR = Orbit()
COLOURS = np.array([[110.0, 70.0, 30.0], [40.0, 150.0, 40.0]])


def orbit_of(kind: str, seed: int, orbit: Orbit = NEAR):
    rng = np.random.default_rng(seed)
    stack = random_stack(kind, rng)
    return stack, voxelise(observe(stack, COLOURS, orbit, rng))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["apple tree", "pine tree", "cottage"])
def test_an_object_gets_its_name_place_and_size(kind, seed):
    stack, voxels = orbit_of(kind, seed)
    found = max(recognise(voxels, SETTINGS).objects, key=lambda thing: thing.num_voxels)
    assert found.label == kind
    assert found.centre[::2] == pytest.approx(stack.axis, abs=0.1)
    assert found.size[1] == pytest.approx(stack.heights[-1], rel=0.1)
    assert found.parts[0].solid.radius == pytest.approx(stack.radii[0][0], rel=0.05)


def test_an_empty_map_holds_nothing():
    _, voxels = orbit_of("cottage", 0)
    nothing = voxels.select(slice(0, 0))
    found = recognise(nothing, SETTINGS)
    assert found.objects == ()
    assert components(nothing, SETTINGS).shape == (0,)


def test_the_ground_belongs_to_no_object():
    _, voxels = orbit_of("cottage", 0)
    label = recognise(voxels, SETTINGS).label
    low = voxels.centres[:, 1] < SETTINGS.ground_clearance
    assert low.any()
    assert (label[low] == -1).all()
    assert (label[~low] >= 0).any()


def test_the_order_of_cells_does_not_matter():
    _, voxels = orbit_of("pine tree", 1)
    order = np.random.default_rng(0).permutation(len(voxels))
    shuffled: Voxels = voxels.select(order)
    straight, mixed = recognise(voxels, SETTINGS), recognise(shuffled, SETTINGS)
    assert [thing.label for thing in straight.objects] == [thing.label for thing in mixed.objects]
    assert (straight.label[order] == mixed.label).all()
