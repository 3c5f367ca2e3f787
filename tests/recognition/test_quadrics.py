"""The thesis's quadric fit is exact if its assumptions hold, and wrong otherwise."""

import numpy as np
import pytest

from recon.recognition.fitting.quadrics import (
    half_axes_sq,
    quadric_shape,
    thesis_quadric,
)
from recon.records import FitFailure


def test_half_axes_of_an_ellipsoid_are_recovered(surfaces):
    rng = np.random.default_rng(0)
    points = surfaces.ball(rng, [3.0, 2.0, 1.0], 300) @ surfaces.rotation(rng).T + [4.0, -3.0, 2.0]
    squares = half_axes_sq(thesis_quadric(points))
    np.testing.assert_allclose(np.sort(squares), [1.0, 4.0, 9.0], rtol=1e-5)


@pytest.mark.parametrize(("kind", "told"), [("sphere", "sphere"), ("truncated cone", "cone")])
def test_shapes_with_three_eigenvalues_are_classified(kind, told, surfaces):
    rng = np.random.default_rng(1)
    points = np.add(surfaces.make(kind, rng), [2.0, 3.0, 4.0])
    assert quadric_shape(half_axes_sq(thesis_quadric(points))) == told


def test_coefficients_are_those_of_equation_46(surfaces):
    points = np.add(surfaces.ball(np.random.default_rng(2), 2.0, 200), [1.0, 0.0, 0.0])
    # (x - 1)^2 + y^2 + z^2 = 4, that is G = -1 and L = -3.
    expected = [1, 1, 1, 0, 0, 0, -1, 0, 0, -3]
    np.testing.assert_allclose(thesis_quadric(points), expected, atol=1e-9)


def test_sign_of_a_cylinders_third_eigenvalue_is_noise(surfaces):
    told = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        points = surfaces.frustum(rng, 2.0, 2.0, 8.0, 300)[:, [0, 2, 1]]
        noisy = points + 0.1 * rng.normal(size=points.shape)
        told.append(quadric_shape(half_axes_sq(thesis_quadric(noisy))))
    # This is why it is the reference and not the default.
    assert 0.2 < told.count("cone") / len(told) < 0.8


def test_lying_cylinder_violates_the_assumption_of_a_nonzero_coefficient(surfaces):
    rng = np.random.default_rng(3)
    along_x = surfaces.frustum(rng, 2.0, 2.0, 8.0, 300)[:, [2, 0, 1]]
    noisy = along_x + 0.02 * rng.normal(size=along_x.shape)
    assert quadric_shape(half_axes_sq(thesis_quadric(noisy))) != "cylinder"


def test_quadric_without_real_points_is_a_failure():
    failure = quadric_shape(np.array([-1.0, -2.0, -3.0]))
    assert isinstance(failure, FitFailure)
    assert "no half axis" in failure.reason
