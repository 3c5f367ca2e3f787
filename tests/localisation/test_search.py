"""Search over all positions: an upright camera is located, or the ambiguity is reported."""

from dataclasses import replace

import numpy as np
import pytest

from recon.camera import StereoRig
from recon.geometry import invert, pose, rotation_about_y, transform
from recon.localisation.candidates import Candidate, decide, distinct
from recon.localisation.completion import completed, thinned
from recon.localisation.directions import Directions
from recon.localisation.graph import planar
from recon.localisation.registration import Points
from recon.localisation.search import Search
from recon.localisation.silhouettes import Shape, agreement
from recon.localisation.stance import Stance, tilt_by, tilt_of
from recon.localisation.surfels import Surfels
from recon.records import FitFailure, FoundObject, Part, PoseEstimate, Sphere, Voxels

RIG = StereoRig(
    width=192,
    height=192,
    focal_px=114.0,
    cx_left_px=95.5,
    cx_right_px=95.5,
    cy_px=95.5,
    baseline=0.3,
)
HEIGHT = 5.0
CENTRES = np.array([[0.0, 4.0, 0.0], [16.0, 4.0, 5.0], [5.0, 4.0, 22.0]])
RADII = np.array([3.0, 2.0, 4.0])


def balls(rng, number, centres=CENTRES, radii=RADII):
    """Sample points on the surfaces of some balls."""
    ways = rng.normal(size=(len(radii), number, 3))
    ways /= np.linalg.norm(ways, axis=2, keepdims=True)
    return (centres[:, None] + radii[:, None, None] * ways).reshape(-1, 3)


def voxels_of(points):
    number = len(points)
    return Voxels(
        index=np.floor(points).astype(np.int64), centres=np.floor(points) + 0.5, means=points,
        counts=np.ones(number, np.int64), colours=None, cell_size=1.0,
    )  # fmt: skip


def search_of(points, stance):
    return Search(
        stance=stance,
        shape=Shape(points=points, size=1.0),
        coarse=Shape(points=thinned(points, 2.0), size=2.0),
        surfels=Surfels.through(points, 1.0),
        places=np.array(
            [[x, HEIGHT, z] for x in range(-12, 14, 2) for z in range(-16, 14, 2)], float
        ),
    )


def seen_from(T_world_left, points, rng):
    """Take the points that a camera sees, with stereo noise along their rays."""
    left = transform(invert(T_world_left), points)
    ahead = left[left[:, 2] > 1.0]
    pixels = RIG.project_left(ahead)
    inside = ((pixels >= 0) & (pixels < 192)).all(axis=1)
    left, pixel = ahead[inside], np.round(pixels[inside] / 3.0)
    order = np.argsort(left[:, 2])
    _, nearest = np.unique(pixel[order], axis=0, return_index=True)
    left = left[order][nearest]
    sigma = 0.1 * left[:, 2] ** 2 / (RIG.focal_px * RIG.baseline)
    noisy = left * (1.0 + rng.normal(size=len(left)) * sigma / left[:, 2])[:, None]
    return Points(points_left=noisy, sigma=sigma, across=0.7 / RIG.focal_px * left[:, 2])


@pytest.fixture(scope="module")
def stance():
    return Stance(height=HEIGHT, pitches=(0.0,))


@pytest.fixture(scope="module")
def world():
    return balls(np.random.default_rng(1), 6000)


def test_three_objects_determine_the_pose(world, stance):
    true = stance.at(np.array([-8.3, -9.4, 0.85]), 0.0)
    points = seen_from(true, world, np.random.default_rng(2))
    found = search_of(thinned(world, 1.0), stance).recall(points, RIG, [])
    assert isinstance(found, PoseEstimate)
    off = found.T_world_left[:3, 3] - true[:3, 3]
    assert np.linalg.norm(off) < 0.3
    assert abs(planar(found.T_world_left)[2] - 0.85) < np.radians(2.0)
    assert 0.005 < found.sigma < 0.3


def test_single_ball_leaves_the_pose_ambiguous(stance):
    ball = balls(np.random.default_rng(1), 6000, CENTRES[:1], RADII[:1])
    true = stance.at(np.array([-8.3, -4.0, 0.4]), 0.0)
    points = seen_from(true, ball, np.random.default_rng(2))
    found = search_of(thinned(ball, 1.0), stance).recall(points, RIG, [])
    assert isinstance(found, FitFailure)
    assert "several places" in found.reason or "exact place" in found.reason


def test_too_few_points_are_reported(world, stance):
    points = Points(points_left=np.ones((5, 3)), sigma=np.ones(5), across=np.ones(5))
    found = search_of(thinned(world, 1.0), stance).recall(points, RIG, [])
    assert found.reason == "too little is seen"


def test_true_pose_agrees_better_than_others(world, stance):
    place = np.array([-8.3, -9.4, 0.85])
    points = seen_from(stance.at(place, 0.0), world, np.random.default_rng(2))
    tilt = tilt_by(0.0)
    seen = Directions.of(points.points_left @ tilt.T, points.sigma, RIG, tilt, np.radians(1.0))
    near = np.empty((seen.grid.num_columns, seen.grid.num_rows))
    shape = Shape(points=thinned(world, 1.0), size=1.0)

    def value(step):
        return agreement(shape, place + step, HEIGHT, seen.grid, seen.seen, near)

    assert value([0.0, 0.0, 0.0]) > 0.6 * seen.seen.weight.sum()
    for step in ([3.0, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, 0.1], [0.0, 0.0, 3.0]):
        assert value(step) < value([0.0, 0.0, 0.0]) - 3.0


def test_stance_needs_upright_cameras_of_one_height():
    poses = np.array(
        [pose(rotation_about_y(turn) @ tilt_by(0.18), [turn, 5.0, 1.0]) for turn in (0.0, 1.0, 4.0)]
    )
    stance = Stance.of(poses, 1.0)
    assert np.allclose(np.degrees(stance.pitches), [10.0])
    assert np.allclose(tilt_of(poses[1]), tilt_by(0.18))
    again = stance.at(planar(poses[2]), 0.18)
    assert np.allclose(again, poses[2])
    poses[1, 1, 3] = 5.5
    assert Stance.of(poses, 1.0) is None
    assert Stance.of(poses[:0], 1.0) is None


def test_unseen_sides_are_completed_from_fitted_solids():
    ball = Sphere(centre=np.array([0.0, 4.0, 0.0]), radius=3.0)
    front = balls(np.random.default_rng(1), 2000, CENTRES[:1], RADII[:1])
    front = thinned(front[front[:, 2] > 0.0], 1.0)
    part = Part(role="crown", solid=ball, hue_deg=None, num_voxels=9, rms=0.1)
    found = FoundObject(
        id=0, label="tree", probability=0.9, centre=ball.centre, size=np.full(3, 6.0),
        num_voxels=9, parts=(part,),
    )  # fmt: skip
    whole = completed(voxels_of(front), (found,))
    assert ball.distances(whole).max() < 0.5
    assert (whole[:, 2] < -1.0).sum() > 0.7 * (whole[:, 2] > 1.0).sum() > 20
    assert np.allclose(completed(voxels_of(front), ()), front)
    # A wide ball through what is nearly flat says nothing of the unseen sides.
    wide = replace(part, solid=replace(ball, radius=9.0))
    assert np.allclose(completed(voxels_of(front), (replace(found, parts=(wide,)),)), front)


def candidate(x, evidence, sigma=0.05, is_known=False, reach=0.0):
    estimate = PoseEstimate(
        T_world_left=pose(tilt_by(0.0), [x, 5.0, 0.0]), covariance=sigma**2 * np.eye(6),
        probability=0.0, residual=1.0, inlier_share=0.9, num_cells=99,
    )  # fmt: skip
    return Candidate(estimate=estimate, evidence=evidence, is_known=is_known, reach=reach)


def test_pose_is_returned_only_if_clearly_better_than_others():
    said = decide([candidate(0.0, 30.0), candidate(9.0, 20.0)], 1.0)
    assert said.T_world_left[0, 3] == 0.0
    assert said.probability > 0.99
    assert "several" in decide([candidate(0.0, 30.0), candidate(9.0, 29.0)], 1.0).reason
    assert "too little" in decide([candidate(0.0, 7.0)], 1.0).reason
    assert "exact place" in decide([candidate(0.0, 30.0, sigma=0.5)], 1.0).reason
    assert decide([], 1.0).reason == "no place looks like it"
    assert candidate(0.0, 1.0).is_apart(candidate(0.7, 1.0), 1.0)
    assert not candidate(0.0, 1.0).is_apart(candidate(0.3, 1.0), 1.0)


def test_features_resolve_a_pose_that_shape_leaves_ambiguous():
    open_place = candidate(1.5, 30.0, sigma=0.9)
    known = candidate(0.0, 29.0, is_known=True)
    assert "exact place" in decide(distinct([open_place, candidate(0.0, 29.0)], 1.0), 1.0).reason
    said = decide(distinct([open_place, known, candidate(40.0, 2.0)], 1.0), 1.0)
    assert said.T_world_left[0, 3] == 0.0
    assert said.sigma == pytest.approx(0.05)
    # A vague one does not help.
    vague = candidate(0.0, 29.0, sigma=0.95, is_known=True)
    assert "exact place" in decide(distinct([open_place, vague], 1.0), 1.0).reason
    # Poses that the same features would have distinguished are not confused with it.
    seen = candidate(0.0, 30.0, is_known=True, reach=9.0)
    beside, beyond = candidate(4.0, 29.5), candidate(12.0, 29.5)
    assert len(distinct([seen, beside, beyond], 1.0)) == 2
    assert len(distinct([candidate(0.0, 30.0, reach=9.0), beside, beyond], 1.0)) == 3
    # Features of another place do not resolve it.
    elsewhere = candidate(9.0, 29.0, is_known=True)
    assert "several" in decide(distinct([open_place, elsewhere], 1.0), 1.0).reason


def test_upright_camera_takes_the_height_of_its_run(stance):
    true = stance.at(np.array([3.0, -2.0, 0.7]), stance.pitches[0])
    covariance = np.diag(np.repeat([np.radians(1.0), 0.3], 3) ** 2)
    lifted = pose(true[:3, :3], true[:3, 3] + [0.1, 0.4, 0.0])
    found = stance.upright(
        PoseEstimate(
            T_world_left=lifted, covariance=covariance, probability=0.0, residual=1.0,
            inlier_share=1.0, num_cells=0,
        ),
        1.0,
    )  # fmt: skip
    np.testing.assert_allclose(found.T_world_left[:3, 3], [3.1, HEIGHT, -2.0], atol=0.03)
    assert found.covariance[4, 4] < 0.06**2
    assert found.covariance[3, 3] == pytest.approx(0.3**2, rel=0.1)
