"""The sigma of motions between places is that of their errors, in worlds of no choice."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from recon.geometry import invert
from recon.localisation.place_errors import motion_covariance
from recon.localisation.precision import information
from recon.records import View
from recon.sequences.odometry.motion import linearise
from recon.sequences.odometry.places import meet, see
from recon.settings import Settings, updated
from recon.world.generator import random_scene
from recon.world.world import World

SEEDS, NOISES = (371, 372, 373), (0.0, 5.0)
MIN_AGREEING = 24
"""Motions of fewer points are used by nothing that states their sigma."""


def ring(middle, reach):
    """Views around a thing, 4 degrees apart."""
    angles = np.radians(np.arange(0.0, 40.0, 4.0))
    away = (reach + 16.0) * np.column_stack([np.cos(angles), 0.0 * angles, np.sin(angles)])
    return [View(position=middle + side, target=middle) for side in away]


def drive(middle, reach):
    """Views on the way towards a thing, a unit apart, past its side."""
    ahead = -middle * [1.0, 0.0, 1.0] / np.linalg.norm(middle[[0, 2]])
    beside = middle + 2.0 * ahead[[2, 1, 0]] * [1.0, 0.0, -1.0]
    return [
        View(position=beside + (reach + away) * ahead, target=beside)
        for away in np.arange(26.0, 16.0, -1.0)
    ]


@cache
def motions(views):
    """Motions between neighbouring views, with their errors (6,)."""
    worlds = [world(seed, noise) for seed in SEEDS for noise in NOISES]
    pairs = [[one.take(view) for view in views(*first_thing(one))] for one in worlds]
    both = [two for taken in pairs for two in pairwise(taken)]
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


@pytest.mark.parametrize("views", [ring, drive])
def test_overlapping_windows_are_not_independent(views):
    """Without the weights of points that share their errors, sigma would be too small."""
    assert (np.array(ratios(views, as_if_independent)) > 1.4).all()


def as_if_independent(met, rig):
    at = linearise(met.T_second_first, met.tracks, rig)
    return np.linalg.pinv(information(at.residual, at.by_motion, np.ones(len(met.tracks))))
