"""Poses estimated from images of known motion."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recon.camera import StereoRig
from recon.errors import InputError
from recon.geometry import pose
from recon.records import StereoPair
from recon.sequences.calibration.refinement import (
    RefinedPairs,
    row_residual,
    shared_estimates,
    shared_row_residual,
)
from recon.sequences.estimated_poses import EstimatedPoses
from recon.sequences.frames import DerivedSource, Frame, Recording
from recon.sequences.odometry.errors import drift_percent, paired_poses, trajectory_errors
from recon.sequences.odometry.tracking import sight
from recon.sequences.poses import GivenPoses

RIG = StereoRig(
    width=320, height=160, focal_px=200.0, cx_left_px=160.0, cx_right_px=160.0, cy_px=80.0,
    baseline=0.5,
)  # fmt: skip
UP = np.diag([1.0, -1.0, -1.0, 1.0])


def corridor(number, *, step=0.25):
    """Render a pair in a textured corridor of two walls, a floor and a ceiling."""
    return StereoPair(
        left=_look(0.0, step * number),
        right=_look(RIG.baseline, step * number),
        rig=RIG,
        T_world_left=UP @ pose(np.eye(3), [0, 0, step * number]),
        stamp_s=float(number),
        name=f"{number:06d}",
    )


def _look(x_eye, z_eye):
    v, u = np.mgrid[: RIG.height, : RIG.width]
    rays = RIG.rays(np.column_stack([u.ravel(), v.ravel()]))
    half_width, half_height = 3.0, 1.5
    with np.errstate(divide="ignore"):
        to_wall = np.maximum((half_width - x_eye) / rays[:, 0], (-half_width - x_eye) / rays[:, 0])
        to_floor = half_height / np.abs(rays[:, 1])
        to_end = np.full(len(rays), 30.0 - z_eye)
    depth = np.minimum(np.minimum(to_wall, to_floor), to_end)
    points = rays * depth[:, None] + [x_eye, 0.0, z_eye]
    shade = sum(
        np.sin(points @ direction + phase)
        for direction, phase in zip(_DIRECTIONS, _PHASES, strict=True)
    )
    return np.clip(128 + 22 * shade, 0, 255).astype(np.uint8).reshape(u.shape)


_RNG = np.random.default_rng(2)
_DIRECTIONS = _RNG.normal(size=(24, 3)) * np.geomspace(0.5, 8.0, 24)[:, None]
_PHASES = _RNG.uniform(0, 2 * np.pi, 24)


def recording(pairs):
    return Recording([Frame(name=p.name, stamp_s=p.stamp_s, load=lambda p=p: p) for p in pairs])


def shift_right_image_down(pair):
    """Shift the right image down by 0.6 pixels and remove the pose."""
    shift = np.float32([[1, 0, 0], [0, 1, 0.6]])
    size = (RIG.width, RIG.height)
    right = cv2.warpAffine(pair.right, shift, size, borderMode=cv2.BORDER_REPLICATE)
    return replace(pair, right=right, T_world_left=None)


def row_offset(pair):
    return np.median(sight(pair).row_offset_px)


@pytest.fixture(scope="module")
def drive():
    return [corridor(number) for number in range(8)]


def test_path_is_recovered_with_its_scale(drive):
    source = EstimatedPoses(recording(drive))
    pairs = list(source)
    positions = np.array([pair.T_world_left[:3, 3] for pair in pairs])
    np.testing.assert_array_equal(positions[0], 0)
    np.testing.assert_allclose(positions[-1], [0, 0, -7 * 0.25], atol=0.03)
    assert source.carried == []
    assert 0 < source.metrics["drift_percent"] < 1.5
    assert len(source) == len(pairs) == len(drive)


def test_row_offset_is_estimated_and_removed_from_the_images(drive):
    shifted = [shift_right_image_down(pair) for pair in drive]
    source = EstimatedPoses(recording(shifted))
    straight = list(source)
    assert source.residual.row.coefficients[0] == pytest.approx(0.6, abs=0.1)

    assert abs(row_offset(shifted[3])) > 0.5
    assert abs(row_offset(straight[3])) < 0.1
    assert "drift_percent" not in source.metrics  # there are no reference poses


def test_rows_are_corrected_for_given_poses_but_disparities_stay(drive):
    source = RefinedPairs(recording([shift_right_image_down(pair) for pair in drive]), row_residual)
    straight = list(source)
    assert source.residual.row.coefficients[0] == pytest.approx(0.6, abs=0.1)
    assert not source.residual.disparity.coefficients.any()
    assert abs(row_offset(straight[3])) < 0.1


def test_well_rectified_rigs_and_varying_rigs_are_left_unchanged(drive):
    for pair, straight in zip(drive, RefinedPairs(recording(drive), row_residual), strict=True):
        assert straight is pair
    rigs = [replace(p, rig=replace(RIG, baseline=0.5 + 0.01 * n)) for n, p in enumerate(drive)]
    source = RefinedPairs(recording([shift_right_image_down(pair) for pair in rigs]), row_residual)
    assert not source.residual.row.coefficients.any()
    assert len(list(source)) == len(drive)


def test_recording_is_estimated_once_per_job(drive):
    passes = []

    class CountedReads(DerivedSource):
        def __iter__(self):
            passes.append(len(self))
            return super().__iter__()

    low, straight = recording([shift_right_image_down(pair) for pair in drive]), recording(drive)
    with shared_estimates():
        first = shared_row_residual("low", CountedReads(low))
        assert shared_row_residual("low", CountedReads(low)) is first
        other = shared_row_residual("straight", CountedReads(straight))
    assert len(passes) == 2
    assert first.row.coefficients.any()
    assert not other.row.coefficients.any()
    assert not shared_row_residual("low", CountedReads(straight)).row.coefficients.any()
    assert len(passes) == 3


def test_untrackable_frame_repeats_the_last_motion(drive):
    blank = StereoPair(
        left=np.full((RIG.height, RIG.width), 90, np.uint8),
        right=np.full((RIG.height, RIG.width), 90, np.uint8),
        rig=RIG,
        stamp_s=4.0,
        name="000004",
    )
    source = EstimatedPoses(recording([*drive[:4], blank]))
    positions = np.array([pair.T_world_left[:3, 3] for pair in source])
    assert source.carried == ["000004"]
    assert source.metrics["num_carried"] == 1
    np.testing.assert_allclose(positions[4] - positions[3], positions[3] - positions[2], atol=1e-2)


def test_same_images_give_the_same_poses(drive):
    first, again = (
        np.array([pair.T_world_left for pair in EstimatedPoses(recording(drive[:4]))])
        for _ in range(2)
    )
    np.testing.assert_array_equal(first, again)


def test_single_pair_is_at_the_origin(drive):
    (pair,) = EstimatedPoses(recording(drive[:1]))
    np.testing.assert_array_equal(pair.T_world_left, UP)


def test_changing_rig_is_rejected(drive):
    other = replace(drive[1], rig=replace(RIG, focal_px=210.0))
    with pytest.raises(InputError, match="000001 has a different rig than 000000"):
        list(EstimatedPoses(recording([drive[0], other])))


def test_drift_is_relative_to_the_path_after_alignment():
    true = np.stack([pose(np.eye(3), [0.0, 0.0, z]) for z in range(11)])
    turned = pose(np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]]), [5, 6, 7]) @ true
    assert drift_percent(turned, true) == pytest.approx(0, abs=1e-9)
    longer = true.copy()
    longer[:, 2, 3] *= 1.02
    # Errors from -0.1 to 0.1 in eleven even steps: their root mean square is 0.0632.
    assert drift_percent(longer, true) == pytest.approx(0.632, abs=1e-3)
    with pytest.raises(InputError, match="the true path has no length"):
        drift_percent(true, true[:1].repeat(11, axis=0))


def test_path_errors_equal_the_injected_ones():
    rng = np.random.default_rng(6)
    turns = Rotation.from_rotvec(rng.normal(0, 0.1, (200, 3))).as_matrix()
    true = np.stack([pose(R, [n, np.sin(n), 0.0]) for n, R in enumerate(turns)])
    world = pose(Rotation.from_rotvec([0.3, 0.2, 1.0]).as_matrix(), [5.0, -3.0, 2.0])
    same = trajectory_errors(world @ true, true)
    assert same.ate_rmse == pytest.approx(0, abs=1e-9)
    assert same.rpe_rmse == pytest.approx(0, abs=1e-9)
    shaken = true.copy()
    shaken[:, :3, 3] += rng.normal(0, 0.1, (200, 3))
    errors = trajectory_errors(world @ shaken, true)
    # Noise on three axes, at both ends of a step.
    assert errors.ate_rmse == pytest.approx(0.1 * np.sqrt(3), rel=0.1)
    assert errors.rpe_rmse == pytest.approx(0.1 * np.sqrt(6), rel=0.1)
    assert errors.rpe_rotation_rmse_deg == pytest.approx(0, abs=1e-5)
    assert errors.drift_percent == pytest.approx(100 * errors.ate_rmse / errors.length)


def test_paths_are_matched_by_time_or_by_row():
    poses = np.stack([pose(np.eye(3), [n, 0, 0]) for n in range(6)])
    true = GivenPoses(poses=poses, stamps_s=10.0 + 0.1 * np.arange(6))
    some = GivenPoses(poses=poses[1:4], stamps_s=10.1 + 0.1 * np.arange(3))
    found, wanted = paired_poses(some, true)
    np.testing.assert_allclose(found, wanted, atol=1e-9)
    with pytest.raises(InputError, match="6 true poses without times for 3"):
        paired_poses(some, GivenPoses(poses=poses))
