"""The pose graph of a walk: landmarks and links remove drift as far as they determine it."""

import itertools

import numpy as np

from recon.localisation.graph import FRONT_SHARE, Bearing, Graph
from recon.localisation.links import Link, step_between, step_derivatives

STEP_SIGMA = (0.1, np.radians(1.0))
TREES = np.array([[20.0, 5.0], [-15.0, 20.0], [5.0, -25.0], [30.0, -20.0]])
RADIUS = 4.0


def walked(rng, number=30):
    """Make a round walk as commanded and as executed, each (N, 3)."""
    angle = np.linspace(0.0, 2.0 * np.pi, number)
    meant = np.column_stack([10.0 * np.cos(angle), 10.0 * np.sin(angle), angle + 0.5])
    true = [meant[0]]
    for before, after in itertools.pairwise(meant):
        ahead, aside, turn = step_between(before, after) + rng.normal(size=3) * [0.1, 0.1, 0.0175]
        x, z, a = true[-1]
        c, s = np.cos(a), np.sin(a)
        true.append(np.array([x + c * ahead - s * aside, z + s * ahead + c * aside, a + turn]))
    return meant, np.array(true)


def sighting(rng, pose, number, landmark):
    offset = TREES[landmark] - pose[:2]
    azimuth = np.arctan2(offset[1], offset[0]) - pose[2] + rng.normal(0.0, 0.004)
    distance = np.hypot(*offset) - FRONT_SHARE * RADIUS + rng.normal(0.0, 0.3)
    return Bearing(
        pose=number, landmark=landmark, azimuth_rad=azimuth, distance=distance,
        azimuth_sigma=0.004, distance_sigma=0.3,
    )  # fmt: skip


def solved(rng, sees=True, wrong=0):
    meant, true = walked(rng)
    graph = Graph.at(meant[0], STEP_SIGMA)
    if sees:
        for tree in TREES:
            graph.add(tree + rng.normal(0.0, 1.0, 2), RADIUS)
    for number, pose in enumerate(true):
        if number:
            graph.walk(step_between(meant[number - 1], meant[number]))
        for landmark in range(len(graph.radii)):
            graph.bearings.append(sighting(rng, pose, number, landmark))
    for number in range(wrong):
        graph.bearings.append(sighting(rng, true[number] + [9.0, 9.0, 0.0], number, 0))
    graph.solve()
    off = graph.poses[-1] - true[-1]
    off[2] = np.angle(np.exp(1j * off[2]))
    return off, graph


def test_landmarks_remove_drift_and_the_covariance_is_consistent():
    rng = np.random.default_rng(0)
    runs = [solved(rng) for _ in range(25)]
    ratio = np.mean([off @ np.linalg.solve(g.covariance(), off) / 3.0 for off, g in runs])
    assert 0.6 < np.sqrt(ratio) < 1.4
    assert np.sqrt(np.mean([off[:2] @ off[:2] for off, _ in runs])) < 0.3
    blind = [solved(rng, sees=False) for _ in range(25)]
    ratio = np.mean([off @ np.linalg.solve(g.covariance(), off) / 3.0 for off, g in blind])
    assert 0.6 < np.sqrt(ratio) < 1.4
    assert np.sqrt(np.mean([off[:2] @ off[:2] for off, _ in blind])) > 0.6


def test_wrong_data_associations_do_not_distort_the_path():
    off, _ = solved(np.random.default_rng(1), wrong=5)
    assert np.hypot(*off[:2]) < 0.4


def test_link_to_the_start_closes_the_path():
    rng = np.random.default_rng(2)
    meant, true = walked(rng)
    graph = Graph.at(meant[0], STEP_SIGMA)
    for before, after in itertools.pairwise(meant):
        graph.walk(step_between(before, after))
    before = np.hypot(*(graph.poses[-1] - true[-1])[:2])
    last = len(true) - 1
    information = np.diag([0.02**-2.0, 0.02**-2.0, 0.001**-2.0])
    step = step_between(*true[[0, last]])
    graph.links.append(Link(first=0, second=last, step=step, information=information))
    graph.solve()
    assert np.hypot(*(graph.poses[-1] - true[-1])[:2]) < 0.1 < before
    middle = len(true) // 2
    assert np.hypot(*(graph.poses - true)[middle, :2]) < np.hypot(*(meant - true)[middle, :2])
    elsewhere = step + np.array([7.0, 7.0, 1.0])
    graph.links.append(Link(first=0, second=last, step=elsewhere, information=information))
    graph.solve()
    assert np.hypot(*(graph.poses[-1] - true[-1])[:2]) < 0.1


def test_derivatives_of_steps_match_differences():
    rng = np.random.default_rng(3)
    both = rng.normal(size=(2, 1, 3))
    derivative = step_derivatives(*both)[0]
    for column in range(6):
        change = np.zeros(6)
        change[column] = 1e-6
        moved = both + change.reshape(2, 1, 3)
        numeric = (step_between(*moved[:, 0]) - step_between(*both[:, 0])) / 1e-6
        np.testing.assert_allclose(derivative[:, column], numeric, atol=1e-4)


def test_uncertainty_of_a_step_excludes_that_of_its_start():
    """An earlier heading error rotates both ends together."""
    meant, _ = walked(np.random.default_rng(4))
    graph = Graph.at(meant[0], STEP_SIGMA)
    for before, after in itertools.pairwise(meant):
        graph.walk(step_between(before, after))
    last = graph.spread_between(len(meant) - 2)
    np.testing.assert_allclose(np.sqrt(np.diag(last)), [0.1, 0.1, np.radians(1.0)], rtol=1e-6)


def test_little_of_another_thing_behind_an_outline_does_not_turn_the_path():
    """Its outline is wider on one side, by less than a house seen from another side."""
    away = np.hypot(*TREES[0])
    half, azimuth = np.arcsin(RADIUS / away), np.arctan2(*TREES[0, ::-1])
    graph = Graph.at(np.zeros(3), STEP_SIGMA)
    graph.add(TREES[0], RADIUS)
    for number, wider in enumerate((0.0, 0.0, 0.3 * half)):
        if number:
            graph.walk(np.zeros(3))
        graph.bearings.append(
            Bearing(
                pose=number, landmark=0, azimuth_rad=azimuth + wider / 2.0,
                distance=away - FRONT_SHARE * RADIUS, azimuth_sigma=0.001, distance_sigma=0.3,
                half_rad=half + wider / 2.0,
            )
        )  # fmt: skip
    graph.solve()
    assert abs(graph.poses[-1, 2]) < 0.3 * 0.15 * half
