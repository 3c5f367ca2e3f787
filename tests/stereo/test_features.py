"""Features lie on ridges, in the requested number; invalid images are rejected in one line."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.settings import FeatureSettings
from recon.stereo.features import detect
from scenes import textured_pair

METHODS = ["steerable", "population"]


@pytest.mark.parametrize("method", METHODS)
def test_number_of_features_follows_the_share(plane, method):
    few, many = (
        len(detect(plane[0], FeatureSettings(share=share, method=method))) for share in (0.02, 0.05)
    )
    assert few == pytest.approx(0.02 * plane[0].size, rel=0.02)
    assert many == pytest.approx(0.05 * plane[0].size, rel=0.02)


@pytest.mark.parametrize("method", METHODS)
def test_step_gives_one_thin_line_with_its_normal(method):
    image = np.full((60, 60), 60, np.uint8)
    image[:, 30:] = 180
    features = detect(image, FeatureSettings(share=0.02, widths_px=(2.0, 4.0), method=method))
    inner = (features.points_px[:, 1] > 10) & (features.points_px[:, 1] < 50)
    u = features.points_px[inner, 0]
    assert set(u) <= {29, 30}
    across = np.minimum(features.orientation_rad, np.pi - features.orientation_rad)
    assert across[inner].max() < np.radians(2)


def test_thinning_leaves_no_adjacent_features_across_an_edge(plane):
    features = detect(plane[0], FeatureSettings())
    place = {(u, v) for u, v in features.points_px.astype(int).tolist()}
    flat = np.abs(np.cos(features.orientation_rad)) > 0.99
    beside = [
        (u + 1, v) in place and (u - 1, v) in place
        for u, v in features.points_px[flat].astype(int).tolist()
    ]
    assert not any(beside)


def test_threshold_applies_whatever_the_share(plane):
    settings = FeatureSettings(share=1.0, threshold=30.0)
    features = detect(plane[0], settings)
    assert features.modulus.min() >= 30.0
    assert 0 < len(features) < len(detect(plane[0], FeatureSettings(share=1.0)))


def test_points_are_in_row_order(plane_features):
    u, v = plane_features[0].points_px.T
    place = v * 10_000 + u
    assert (np.diff(place) > 0).all()


def test_colour_is_converted_to_brightness(plane):
    grey = detect(plane[0], FeatureSettings())
    colour = detect(np.repeat(plane[0][..., None], 3, axis=2), FeatureSettings())
    np.testing.assert_array_equal(grey.points_px, colour.points_px)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (50, 1), (5, 5), (40, 40)])
def test_blank_images_have_no_features(method, shape):
    assert len(detect(np.full(shape, 77, np.uint8), FeatureSettings(method=method))) == 0


def test_share_zero_gives_no_features(plane):
    assert len(detect(plane[0], FeatureSettings(share=0.0))) == 0


@pytest.mark.parametrize(
    ("image", "message"),
    [
        (np.zeros((9, 9)), "image is float64, but uint8 is needed"),
        (np.full((9, 9), np.nan, np.float32), "image is float32, but uint8 is needed"),
        (np.zeros((9, 9), np.uint16), "image is uint16, but uint8 is needed"),
        (np.zeros((9, 9, 4), np.uint8), r"shape \(9, 9, 4\)"),
        (np.zeros((0, 9), np.uint8), r"shape \(0, 9\)"),
        (np.zeros(9, np.uint8), r"shape \(9,\)"),
    ],
)
def test_invalid_image_is_rejected(image, message):
    with pytest.raises(InputError, match=message):
        detect(image, FeatureSettings())


def test_image_is_not_modified():
    left, _, _ = textured_pair(shape=(40, 40))
    left.flags.writeable = False
    detect(left, FeatureSettings())
