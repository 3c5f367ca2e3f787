"""Segmentation by colour: Appendix D's hue, region growing, clusters, rejected input."""

import colorsys

import numpy as np
import pytest

from recon.recognition.colour import mean_hue_deg, rgb_to_hsv
from recon.recognition.segments.segmentation import grow_hue, split_colours
from recon.records import FitFailure, Voxels

BROWN, GREEN, RED, GREY = [110, 70, 30], [40, 150, 40], [200, 40, 40], [120, 121, 120]


def column(lower, upper, *, spread=6.0, seed=0):
    """Make a 4 x 20 x 4 block of cells with lower and upper halves of different colours."""
    index = np.stack(np.meshgrid(range(4), range(20), range(4), indexing="ij"), -1).reshape(-1, 3)
    rng = np.random.default_rng(seed)
    colour = np.where(index[:, 1:2] < 10, lower, upper) + rng.normal(0, spread, (len(index), 3))
    return Voxels(
        index=index,
        centres=index + 0.5,
        means=index + 0.5,
        counts=np.full(len(index), 9),
        colours=np.clip(colour, 0, 255).astype(np.uint8),
        cell_size=1.0,
    )


def test_hue_saturation_and_value_match_the_standard():
    colours = np.random.default_rng(0).integers(0, 256, (200, 3)).astype(np.uint8)
    expected = np.array([colorsys.rgb_to_hsv(*(rgb / 255)) for rgb in colours])
    found = rgb_to_hsv(colours)
    has_hue = found[:, 0] >= 0
    np.testing.assert_allclose(found[has_hue, 0], 360 * expected[has_hue, 0], atol=1e-9)
    np.testing.assert_allclose(found[:, 1:], expected[:, 1:], atol=1e-12)


def test_grey_has_no_hue():
    grey = np.full((5, 3), 90, np.uint8)
    assert (rgb_to_hsv(grey)[:, 0] == -1).all()
    assert mean_hue_deg(grey) is None


def test_mean_of_reds_around_zero_hue_is_red():
    reds = np.array([[200, 0, 10], [200, 10, 0]] * 5, np.uint8)
    hue = mean_hue_deg(reds)
    assert min(hue, 360 - hue) < 2


def test_uniformly_distributed_hues_have_no_mean():
    assert mean_hue_deg(np.array([RED, GREEN, [40, 40, 200]], np.uint8)) is None


def test_neighbours_of_one_hue_form_one_segment():
    segments = grow_hue(column(BROWN, GREEN, spread=0.5), 15.0)
    assert segments.label.max() == 1
    lower = column(BROWN, GREEN).index[:, 1] < 10
    assert len(set(segments.label[lower])) == 1
    assert len(set(segments.label[~lower])) == 1


def test_hue_across_zero_is_one_segment():
    assert grow_hue(column([200, 0, 10], [200, 10, 0], spread=0.0), 7.0).label.max() == 0


def test_hue_noise_fragments_the_region_growing_of_the_thesis():
    assert grow_hue(column(BROWN, GREEN, spread=25.0), 7.0).label.max() >= 10


@pytest.mark.parametrize("lower", [BROWN, GREY])
def test_chroma_clusters_separate_crown_and_body(lower):
    voxels = column(lower, GREEN, spread=15.0)
    segments = split_colours(voxels)
    assert segments, segments.reason
    assert (segments.label == (voxels.index[:, 1] >= 10)).mean() > 0.97


@pytest.mark.parametrize(
    ("lower", "upper", "reason"),
    [
        (GREEN, GREEN, "one colour|run into each other|one hue"),
        (RED, [200, 60, 40], "run into each other|one hue"),
        (GREY, GREY, "one colour|run into each other"),
    ],
)
def test_inseparable_colours_are_rejected(lower, upper, reason):
    failure = split_colours(column(lower, upper))
    assert isinstance(failure, FitFailure)
    assert any(part in failure.reason for part in reason.split("|")), failure.reason


def test_single_colour_is_rejected():
    failure = split_colours(column(GREEN, GREEN, spread=0.0))
    assert failure.reason == "all cells have one colour"
