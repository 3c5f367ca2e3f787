"""Recorded pairs with truth: success rates at the thesis's numbers of pairs (Tables 1 and 3)."""

import json

import cv2
import numpy as np
import pytest

from recon.settings import Settings, updated, with_quality
from recon.stereo.evaluation import evaluate
from recon.stereo.features import detect
from recon.stereo.matching.matching import match
from recon.stereo.subpixel import refine
from scenes import noisy

pytestmark = pytest.mark.data

# Folder, largest disparity, K, success in percent that fast and best must reach at K.
PAIRS = [
    ("middlebury2001/venus", 20, 1310, 99.0, 99.5),
    ("middlebury2001/sawtooth", 20, 3079, 98.8, 99.5),
    ("middlebury2001/tsukuba", 20, 2350, 98.5, 99.0),
    ("middlebury2001/map", 30, 950, 99.3, 99.5),
    ("middlebury2003/cones", 63, 2615, 98.5, 99.5),
    ("middlebury2005/Moebius", 76, 2654, 97.5, 99.2),
    ("middlebury2005/Books", 78, 2654, 91.5, 98.0),
]


def read(folder):
    scale = json.loads((folder / "meta.json").read_text())["truth_scale"]
    left, right, truth = (
        cv2.imread(str(folder / name), cv2.IMREAD_UNCHANGED)
        for name in ("left.png", "right.png", "disp_left.png")
    )
    truth = truth.astype(float) / scale
    truth[truth == 0] = np.nan
    return left, right, truth


def solve(folder, quality, max_disparity, noise=0.0):
    left, right, truth = read(folder)
    rng = np.random.default_rng(4)
    left, right = (noisy(image, noise, rng) for image in (left, right))
    s = updated(with_quality(Settings(), quality), {"matching": {"max_disparity": max_disparity}})
    pair = detect(left, s.features), detect(right, s.features)
    return refine(match(*pair, s.matching), *pair), truth


@pytest.mark.parametrize(("name", "last", "num", "fast", "best"), PAIRS, ids=lambda x: str(x))
def test_success_at_k(data_dir, name, last, num, fast, best):
    step = 1.0 if name.endswith("tsukuba") else 0.0
    for quality, bar in (("fast", fast), ("best", best)):
        matches, truth = solve(data_dir / name, quality, last)
        assert len(matches) >= num
        assert evaluate(matches.select(slice(0, num)), truth, step).success_all >= bar
        if quality == "best":
            twice = evaluate(matches.select(slice(0, 2 * num)), truth, step)
            assert twice.success_all >= bar - 1.0


def test_subpixel_refinement_and_sigma_on_venus(data_dir):
    matches, truth = solve(data_dir / "middlebury2001/venus", "best", 20)
    found = evaluate(matches.select(slice(0, 1310)), truth)
    assert 0.02 < found.subpixel_median_px <= 0.09
    assert found.subpixel_rms_px <= 0.20


@pytest.mark.parametrize("name", ["middlebury2001/sawtooth", "middlebury2005/Moebius"])
def test_sigma_is_consistent_on_recorded_pairs(data_dir, name):
    matches, truth = solve(data_dir / name, "best", 78)
    u, v = matches.points_px.astype(int).T
    error = matches.disparity_px - truth[v, u]
    good = np.abs(error) <= 1
    assert 0.75 < np.sqrt(np.mean((error[good] / matches.sigma_px[good]) ** 2)) < 1.25


def miscalibration(probability, is_right):
    """Average the distance of the probability from the share of correct matches, over bins."""
    number = np.digitize(probability, [0.5, 0.8, 0.95, 0.99])
    gaps = [abs((probability - is_right)[number == k].sum()) for k in range(5)]
    return sum(gaps) / len(probability)


@pytest.mark.parametrize("name", ["middlebury2005/Moebius", "middlebury2006/Baby1"])
@pytest.mark.parametrize("quality", ["fast", "best"])
@pytest.mark.parametrize(("noise", "bar"), [(0.0, 0.025), (10.0, 0.05)])
def test_probability_is_calibrated_on_recorded_pairs(data_dir, name, quality, noise, bar):
    matches, truth = solve(data_dir / name, quality, 110, noise)
    u, v = matches.points_px.astype(int).T
    error = np.abs(matches.disparity_px - truth[v, u])
    known = np.isfinite(error)
    probability, is_right = matches.probability[known], error[known] <= 1
    assert miscalibration(probability, is_right) < bar
    in_disorder = np.random.default_rng(5).permutation(probability)
    assert miscalibration(in_disorder, is_right) > 1.5 * bar
