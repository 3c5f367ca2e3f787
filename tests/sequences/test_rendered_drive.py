"""A drive through a simulated village with known poses and a slightly misaligned rig."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from recon.records import View
from recon.sequences.calibration.row_error import Field, Residual
from recon.sequences.estimated_poses import EstimatedPoses
from recon.sequences.frames import Frame, Recording
from recon.settings import Settings, updated
from recon.world.world import World

SCENE = Path(__file__).parents[2] / "scenes" / "village.scene"
EYES = {"width": 640, "height": 360, "baseline": 1.0, "fov_deg": 75.0}


@pytest.fixture(scope="module")
def drive():
    world = World.from_file(SCENE, updated(Settings(), {"eyes": EYES}))
    pairs = []
    for number in range(10):
        turn = 0.03 * number
        position = np.array([-40 + 5 * np.sin(3 * turn) + 2 * number, 5.0, 60.0 - 2 * number])
        ahead = np.array([0.8 * np.cos(turn + 0.2), 0.0, -1.0])
        target = position + 20 * ahead / np.linalg.norm(ahead)  # fixed distance, fixed rig
        pair = world.take(View(position=position, target=target))
        pairs.append(replace(pair, stamp_s=float(number), name=str(number)))
    return pairs


def distort_pair(pair, disparity, row):
    """Distort the right image by smooth fields of rows and disparities."""
    left_over = Residual(
        disparity=Field(coefficients=-np.array(disparity)), row=Field(coefficients=-np.array(row))
    )
    maps = left_over.maps(pair.rig)
    if maps is None:
        return pair
    right = cv2.remap(pair.right, *maps, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return replace(pair, right=right)


@pytest.mark.parametrize(
    ("disparity", "row"),
    [
        pytest.param([0.0] * 6, [0.0] * 6, id="straight"),
        pytest.param([1.2, 0, 0, 0, 0, 0], [0.0] * 6, id="constant"),
        pytest.param([0.3, 0.1, -0.2, 0.9, 0.1, 0.1], [-0.1, 0, 0, 0, 1.0, 0], id="quadratic"),
    ],
)
def test_residual_is_recovered_and_the_path_keeps_its_scale(drive, disparity, row):
    pairs = [distort_pair(pair, disparity, row) for pair in drive]
    frames = [Frame(name=p.name, stamp_s=p.stamp_s, load=lambda p=p: p) for p in pairs]
    source = EstimatedPoses(Recording(frames))
    estimated = np.array([pair.T_world_left[:3, 3] for pair in source])
    true = np.array([pair.T_world_left[:3, 3] for pair in drive])
    np.testing.assert_allclose(source.residual.disparity.coefficients, disparity, atol=0.35)
    np.testing.assert_allclose(source.residual.row.coefficients, row, atol=0.2)
    lengths = [np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in (estimated, true)]
    assert abs(lengths[0] / lengths[1] - 1) < 0.01
    assert 0 < source.metrics["drift_percent"] < 0.5
