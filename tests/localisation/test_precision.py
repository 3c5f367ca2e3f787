"""The sigma of motions between places is that of their errors, in worlds of no choice."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from recon.geometry import invert, pose, rotation_about_y, transform
from recon.localisation.place_errors import OWN_PX, motion_covariance
from recon.localisation.precision import information, shares, supported
from recon.records import View
from recon.sequences.odometry.motion import linearise, refine_motion
from recon.sequences.odometry.places import Meeting, meet, see
from recon.sequences.odometry.tracking import Sightings, Tracks
from recon.settings import Settings, updated
from recon.world.generator import random_scene
from recon.world.world import World
from tests.sequences.drives import RIG

EYES = replace(RIG, focal_px=260.0)
SEEDS, NOISES = (371, 372, 373), (0.0, 5.0)
MIN_AGREEING = 24
"""Motions of fewer points are used by nothing that states their sigma."""


def ring(middle, reach):
    """A row of views around a thing, 4 degrees apart."""
    angles = np.radians(np.arange(0.0, 40.0, 4.0))
    away = (reach + 16.0) * np.column_stack([np.cos(angles), 0.0 * angles, np.sin(angles)])
    return [[View(position=middle + side, target=middle) for side in away]]


def drive(middle, reach):
    """A row of views on the way towards a thing, a unit apart, past its side."""
    ahead = -middle * [1.0, 0.0, 1.0] / np.linalg.norm(middle[[0, 2]])
    beside = middle + 2.0 * ahead[[2, 1, 0]] * [1.0, 0.0, -1.0]
    return [
        [
            View(position=beside + (reach + away) * ahead, target=beside)
            for away in np.arange(26.0, 16.0, -1.0)
        ]
    ]


def walk(middle, reach):
    """Two views each from places around a thing, close to each other and roughly towards it."""
    rng, level = np.random.default_rng(77), np.array([1.0, 0.0, 1.0])
    angles, away = rng.uniform(0.0, 2.0 * np.pi, 10), reach + rng.uniform(8.0, 24.0, 10)
    places = np.column_stack([away * np.cos(angles), 0.0 * angles, away * np.sin(angles)])
    steps, aims = rng.normal(0.0, 1.5, (10, 3)), rng.normal(0.0, 2.0, (10, 2, 3))
    both = np.stack([places, places + steps * level], axis=1)
    return [
        [
            View(position=middle + at, target=middle + aim * level)
            for at, aim in zip(*two, strict=True)
        ]
        for two in zip(both, aims, strict=True)
    ]


@cache
def motions(views):
    """Motions between neighbouring views of each row, with their errors (6,)."""
    worlds = [world(seed, noise) for seed in SEEDS for noise in NOISES]
    rows = [(one, row) for one in worlds for row in views(*first_thing(one))]
    taken = [[one.take(view) for view in row] for one, row in rows]
    both = [two for pairs in taken for two in pairwise(pairs)]
    return [found for first, second in both if (found := motion(first, second)) is not None]


def world(seed, noise):
    chosen = updated(Settings(), {"render": {"noise": noise}})
    scene = random_scene(np.random.default_rng(seed), 6, 8.0)
    return World(scene, chosen.eyes, chosen.render, chosen.world)


def first_thing(of):
    """Middle (3,) and reach of a thing of a world."""
    one = of.objects[0]
    return np.array([one.centre[0], 5.0, one.centre[2]]), max(one.size[[0, 2]]) / 2.0


def motion(first, second):
    """The motion between two pairs, the rig, and its error (6,); None if few points agree."""
    met = meet(see(first), see(second))
    if met is None or met.num_agreeing < MIN_AGREEING:
        return None
    T_second_first = invert(second.T_world_left) @ first.T_world_left
    off = T_second_first @ invert(met.T_second_first)
    turn = Rotation.from_matrix(off[:3, :3]).as_rotvec()
    return met, second.rig, np.append(turn, off[:3, 3])


def ratios(views, covariance):
    """Error over sigma by the median and by the mean: of the motion, its turn and its shift."""
    found = [(off, covariance(met, rig)) for met, rig, off in motions(views)]
    parts = slice(0, 6), slice(0, 3), slice(3, 6)
    return [ratio([(off[part], spread[part, part]) for off, spread in found]) for part in parts]


def ratio(found):
    number = len(found[0][0])
    off_sq = [off @ np.linalg.solve(spread, off) for off, spread in found]
    return np.sqrt([np.median(off_sq) / chi2.median(number), np.mean(off_sq) / number])


@pytest.mark.parametrize("views", [ring, drive])
def test_errors_of_motions_are_those_stated(views):
    assert len(motions(views)) > 40
    found = np.array(ratios(views, motion_covariance))
    assert (found > 0.7).all()
    assert (found < 1.4).all()


def test_errors_of_motions_between_places_of_a_walk_are_those_stated():
    found = np.array(ratios(walk, motion_covariance)[0])
    assert (found > 0.7).all()
    assert (found < 1.4).all()


@pytest.mark.parametrize("found", [(2.0, 2.0, 0.6), (0.6, 2.0, 2.0)])
def test_positions_and_disparities_have_precisions_of_their_own(found):
    """One for both would be too high for the less precise ones."""
    rng, number, one = np.random.default_rng(5), 400, np.broadcast_to(np.eye(3), (400, 3, 3))
    known = information(rng.normal(0.0, found, (number, 3)), one, np.ones(number))
    assert np.sqrt(np.diag(np.linalg.inv(known))) == pytest.approx(
        np.array(found) / np.sqrt(number), rel=0.15
    )


@pytest.mark.parametrize("views", [ring, drive])
def test_overlapping_windows_are_not_independent(views):
    """Without the weights of points that share their errors, sigma would be too small."""
    assert (np.array(ratios(views, as_if_independent)) > 1.4).all()


def as_if_independent(met, rig):
    at = linearise(met.T_second_first, met.tracks, rig)
    return np.linalg.pinv(information(at.residual, at.by_motion, np.ones(len(met.tracks))))


def test_what_errors_of_depth_feign_is_uncertain():
    """A front that is almost flat, seen from two sides, with depths off by the same in both."""
    rng = np.random.default_rng(7)
    found = [front(rng) for _ in range(60)]
    stated = ratio([(off, motion_covariance(met, EYES)) for met, off in found])
    known = ratio([(off, as_known_by_points(met)) for met, off in found])
    assert (stated > 0.7).all()
    assert (stated < 1.4).all()
    assert known[1] > 1.4


def front(rng):
    """A motion around a front as its points tell it, and its error (6,)."""
    number, away = 60, np.array([0.0, 0.0, 130.0]) * EYES.baseline
    points = away + rng.uniform(-1.0, 1.0, (number, 3)) * [20.0, 20.0, 6.0] * EYES.baseline
    T_second_first = pose(rotation_about_y(0.05), away) @ pose(np.eye(3), -away)
    own = rng.normal(0.0, OWN_PX, number)
    first = seen_from(points, own, rng)
    second = seen_from(transform(T_second_first, points), own, rng)
    tracks = Tracks(first=first, second=second)
    refined = refine_motion(T_second_first, tracks, EYES)
    off = T_second_first @ invert(refined)
    met = Meeting(T_second_first=refined, num_agreeing=number, share=1.0, tracks=tracks)
    return met, np.append(Rotation.from_matrix(off[:3, :3]).as_rotvec(), off[:3, 3])


def seen_from(points, own_px, rng):
    """Sightings of points (N, 3) whose disparities have errors of their own."""
    noise = rng.normal(0.0, 0.08, (len(points), 3))
    return Sightings(
        points_px=EYES.project_left(points) + noise[:, :2],
        disparity_px=EYES.disparity(points[:, 2]) + own_px + 0.3 * noise[:, 2],
        row_offset_px=np.zeros(len(points)),
    )


def as_known_by_points(met):
    at, share = linearise(met.T_second_first, met.tracks, EYES), shares(met.tracks)
    return np.linalg.pinv(information(at.residual, at.by_motion, share))


def test_what_one_track_alone_tells_is_not_known():
    """It is followed wherever it errs; of two alike, each confirms the other no more."""
    rng, number = np.random.default_rng(6), 40
    derivative = np.zeros((number, 3, 3))
    derivative[:, [0, 1], [0, 1]] = 1.0
    residual, share = rng.normal(size=(number, 3)), np.ones(number)
    share[:2] = 0.5
    evenly = supported(residual, derivative, share)
    assert information(residual, evenly, share)[:2, :2] == pytest.approx(
        information(residual, derivative, share)[:2, :2], rel=0.05
    )
    derivative[:2, 2, 2] = 1.0
    alone = information(residual, supported(residual, derivative, share), share)
    assert alone[2, 2] < 0.01 * information(residual, derivative, share)[2, 2]
    assert alone[0, 0] == pytest.approx(information(residual, evenly, share)[0, 0], rel=0.1)
