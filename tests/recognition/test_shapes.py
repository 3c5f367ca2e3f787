"""Fits give the right solid with the right parameters, or a reason, in bounded time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.errors import InputError
from recon.recognition.fitting.shapes import MODELS, candidates, fit, from_points
from recon.records import FitFailure

KINDS = ["sphere", "ellipsoid", "cylinder", "cone", "truncated cone", "plane", "box"]


@pytest.mark.parametrize("noise", [0.0, 0.03])
@pytest.mark.parametrize("kind", KINDS)
def test_every_solid_is_classified(kind, noise, surfaces):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        points = surfaces.make(kind, rng) @ surfaces.rotation(rng).T + rng.uniform(-50, 50, 3)
        found = fit(points + noise * rng.normal(size=points.shape))
        assert found, found.reason
        assert found.kind == kind


@pytest.mark.parametrize("kind", ["sphere", "cylinder", "cone", "box"])
def test_residual_matches_the_noise(kind, surfaces):
    rng = np.random.default_rng(1)
    points = surfaces.make(kind, rng, 800)
    one = candidates(points + 0.02 * rng.normal(size=points.shape))[0]
    # The distance to a surface contains one of the three components of the noise.
    assert 0.016 < one.rms < 0.024


def test_parameters_of_a_cylinder_are_recovered(surfaces):
    rng = np.random.default_rng(2)
    points = np.add(surfaces.frustum(rng, 1.5, 1.5, 4.0, 600), [5.0, 6.0, 7.0])
    found = fit(points + 0.01 * rng.normal(size=points.shape))
    assert found.radius == pytest.approx(1.5, rel=0.005)
    assert found.height == pytest.approx(4.0, rel=0.02)
    assert abs(found.axis[2]) == pytest.approx(1.0, abs=1e-4)
    assert found.point[:2] == pytest.approx([5.0, 6.0], abs=0.01)


def test_parameters_of_a_truncated_cone_are_recovered(surfaces):
    rng = np.random.default_rng(3)
    found = fit(surfaces.frustum(rng, 2.5, 1.0, 3.0, 600))
    assert found.radius_bottom == pytest.approx(2.5, rel=0.01)
    assert found.radius_top == pytest.approx(1.0, rel=0.03)
    assert found.axis == pytest.approx([0.0, 0.0, 1.0], abs=1e-4)


def test_covariance_predicts_the_error_of_a_radius(surfaces):
    errors, sigmas = [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        points = surfaces.make("sphere", rng, 200)
        one = from_points("sphere", points + 0.05 * rng.normal(size=points.shape))
        errors.append(one.solid.radius - 2.0)
        sigmas.append(np.sqrt(one.covariance[3, 3]))
    ratio = np.sqrt(np.mean(np.square(errors))) / np.mean(sigmas)
    assert 0.6 < ratio < 1.6


def test_fit_is_robust_to_a_tenth_of_outliers(surfaces):
    rng = np.random.default_rng(4)
    points = surfaces.make("cylinder", rng, 500)
    points[:50] = rng.uniform(-5, 5, (50, 3))
    found = fit(points)
    assert found.kind == "cylinder"
    assert found.radius == pytest.approx(1.5, rel=0.01)


@settings(max_examples=12)
@given(
    kind=st.sampled_from(KINDS),
    seed=st.integers(0, 10_000),
    scale=st.sampled_from([1e-3, 1.0, 1e3]),
)
def test_moving_and_scaling_points_does_not_change_the_shape(surfaces, kind, seed, scale):
    rng = np.random.default_rng(seed)
    points = surfaces.make(kind, rng) + 0.02 * rng.normal(size=(400, 3))
    moved = scale * (points @ surfaces.rotation(rng).T + rng.uniform(-20, 20, 3))
    still, turned = fit(points), fit(moved)
    assert still.kind == turned.kind
    away = turned.distances(moved) / scale
    np.testing.assert_allclose(np.median(away), np.median(still.distances(points)), rtol=0.1)


@pytest.mark.parametrize(
    ("points", "reason"),
    [
        (np.empty((0, 3)), "0 distinct points are too few"),
        (np.ones((1, 3)), "1 distinct points are too few"),
        (np.ones((500, 3)), "1 distinct points are too few"),
        (np.outer(np.arange(50.0), [1.0, 2.0, 3.0]), "on one line"),
        (np.full((30, 3), np.nan), "30 of 30 points are not finite"),
    ],
)
def test_unfittable_points_give_a_reason(points, reason):
    failure = fit(points)
    assert isinstance(failure, FitFailure)
    assert not failure
    assert reason in failure.reason


def test_points_of_wrong_array_shape_are_rejected():
    with pytest.raises(InputError, match=r"points has shape \(4, 2\), but \(N, 3\) is needed"):
        fit(np.ones((4, 2)))


def test_unknown_shape_is_rejected_with_the_known_ones():
    with pytest.raises(InputError, match="shape is 'torus', but one of plane, cylinder"):
        from_points("torus", np.eye(3))


def test_coplanar_points_give_a_plane(surfaces):
    rng = np.random.default_rng(0)
    assert fit(surfaces.make("plane", rng) @ surfaces.rotation(rng).T).kind == "plane"


def test_two_rings_give_a_cylinder_rather_than_a_ball():
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(24)])
    assert fit(np.concatenate([ring, np.add(ring, [0.0, 0.0, 1.5])])).kind == "cylinder"


def test_million_points_give_one_solid(surfaces):
    points = surfaces.make("cone", np.random.default_rng(0), 1_000_000)
    assert fit(points).kind in ("cone", "truncated cone")


def test_duplicate_points_do_not_matter(surfaces):
    points = np.repeat(surfaces.make("sphere", np.random.default_rng(0), 60), 20, axis=0)
    assert fit(points).kind == "sphere"


def test_points_of_low_weight_have_little_influence(surfaces):
    rng = np.random.default_rng(0)
    points = np.concatenate([surfaces.make("sphere", rng, 200), rng.uniform(-4, 4, (150, 3))])
    weights = np.repeat([1.0, 1e-3], [200, 150])
    assert fit(points, weights).radius == pytest.approx(2.0, rel=1e-3)


@pytest.mark.parametrize("shape", MODELS)
def test_every_model_fits_points_of_its_own_shape(shape, surfaces):
    one = from_points(shape, surfaces.make(shape, np.random.default_rng(0)))
    assert one.rms < 1e-3
    assert len(one.covariance) == len(one.covariance.T)
