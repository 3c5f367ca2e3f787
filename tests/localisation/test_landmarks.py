"""Points that images in known places share become landmarks, which locate other images."""

from dataclasses import replace

import numpy as np
import pytest

from recon.geometry import invert, look_at, transform
from recon.localisation.landmarks import landmarks_of
from recon.localisation.relocation import Relocation, located
from recon.localisation.sights import Sight, matched
from recon.records import FitFailure
from tests.localisation.recorded import village

K = np.array([[300.0, 0.0, 160.0], [0.0, 300.0, 120.0], [0.0, 0.0, 1.0]])
NOISE_PX = 0.35


def seen(points, descriptors, number, degrees, rng, noise_px=NOISE_PX):
    """An image of points from a place on a ring around the origin."""
    angle = np.radians(degrees)
    eye = 10.0 * np.array([np.sin(angle), 0.2, np.cos(angle)])
    T_world_camera = look_at(eye, np.zeros(3))
    local = transform(invert(T_world_camera), points)
    px = local[:, :2] / local[:, 2:] * K[0, 0] + K[:2, 2]
    order = rng.permutation(len(points))
    return Sight(
        number=number, T_world_camera=T_world_camera, K=K,
        points_px=(px + rng.normal(0.0, noise_px, px.shape))[order], descriptors=descriptors[order],
    )  # fmt: skip


@pytest.fixture(scope="module")
def scene():
    rng = np.random.default_rng(0)
    points = rng.uniform(-2.0, 2.0, (120, 3))
    return points, rng.integers(0, 120, (120, 128), dtype=np.uint8), rng


def test_points_are_as_far_off_as_their_covariance_states(scene):
    points, descriptors, rng = scene
    sights = [seen(points, descriptors, n, 10.0 * n, rng) for n in range(5)]
    for found in landmarks_of(sights):
        assert len(found) > 100
        row, true = matched(found.rooted, sights[0].rooted)
        assert (row == np.arange(len(found))).all()
        order = [
            int(np.flatnonzero((descriptors == sights[0].descriptors[k]).all(1))[0]) for k in true
        ]
        off = found.points - points[order]
        chi_sq = np.einsum("ni,nij,nj->n", off, np.linalg.inv(found.covariance), off)
        assert 0.6 < np.sqrt(chi_sq.mean() / 3.0) < 1.3


def test_an_image_is_located_as_precisely_as_stated(scene):
    points, descriptors, rng = scene
    known = landmarks_of([seen(points, descriptors, n, 10.0 * n, rng) for n in range(5)])
    chi_sq = []
    for degrees in np.linspace(3.0, 37.0, 8):
        query = seen(points, descriptors, 9, degrees, rng)
        found = located(query, known)
        off = found.T_world_left[:3, 3] - query.eye
        chi_sq.append(off @ np.linalg.solve(found.covariance[3:, 3:], off) / 3.0)
        assert np.linalg.norm(off) < 0.05
        assert found.probability > 0.99
    assert 0.6 < np.sqrt(np.mean(chi_sq)) < 1.5


def test_other_things_are_not_located(scene):
    points, descriptors, rng = scene
    known = landmarks_of([seen(points, descriptors, n, 10.0 * n, rng) for n in range(5)])
    other = rng.integers(0, 120, descriptors.shape, dtype=np.uint8)
    assert not located(seen(points, other, 9, 15.0, rng), known)
    # Features that look alike, but are elsewhere.
    assert not located(seen(rng.permutation(points), descriptors, 9, 15.0, rng), known)


def test_two_places_that_look_alike_are_not_told_apart(scene):
    points, descriptors, rng = scene
    shift = np.array([100.0, 0.0, 0.0])
    sights = [seen(points, descriptors, n, 10.0 * n, rng) for n in range(5)]
    for n in range(5):
        one = seen(points, descriptors, 5 + n, 10.0 * n, rng)
        T_world_camera = one.T_world_camera.copy()
        T_world_camera[:3, 3] += shift
        sights.append(replace(one, T_world_camera=T_world_camera))
    known = landmarks_of(sights)
    found = located(seen(points, descriptors, 99, 15.0, rng), known)
    assert isinstance(found, FitFailure)
    assert found.reason == "several places look like it"


class Known(Relocation):
    """Landmarks of given images."""

    def __init__(self, sights):
        super().__init__([])
        self.__dict__["_known"] = landmarks_of(sights)


def test_images_of_the_run_reveal_how_far_its_poses_are_off(scene):
    points, descriptors, rng = scene
    assert (
        1.0
        <= Known([seen(points, descriptors, n, 5.0 * n, rng) for n in range(9)])._trial.spread
        < 1.5
    )
    sights = []
    for n in range(9):
        one = seen(points, descriptors, n, 5.0 * n, rng)
        T_world_camera = one.T_world_camera.copy()
        T_world_camera[:3, 3] += rng.normal(0.0, 0.03, 3)
        sights.append(replace(one, T_world_camera=T_world_camera))
    assert Known(sights)._trial.spread > 2.0


def test_without_pairs_nothing_is_told():
    pair = village().others[0]
    assert not Relocation([]).recall(pair)
    assert not Relocation([pair]).recall(pair)
