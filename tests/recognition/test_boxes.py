"""The upright box holds the bulk of its points, whatever their number and their turn."""

import numpy as np
import pytest

from recon.recognition.segments.boxes import upright_box


@pytest.mark.parametrize("count", [1, 2, 3, 7, 101, 950])
def test_ends_are_quantiles_of_the_points(count):
    rng = np.random.default_rng(count)
    points = rng.normal(size=(count, 3)) * [3.0, 2.0, 1.0]
    box = upright_box(points)
    low, high = np.quantile(points @ box.axes.T, [0.01, 0.99], axis=0)
    assert box.sizes == pytest.approx(high - low, abs=1e-12)
    assert box.centre == pytest.approx((low + high) / 2.0 @ box.axes, abs=1e-12)


def test_footprint_is_the_smallest_and_outliers_are_outside(surfaces):
    rng = np.random.default_rng(0)
    points = surfaces.box(rng, [6.0, 2.0, 3.0], 900)
    points[:4] *= 20.0
    c, s = np.cos(0.4), np.sin(0.4)
    box = upright_box(points @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]))
    assert sorted(box.sizes) == pytest.approx([2.0, 3.0, 6.0], rel=0.05)
