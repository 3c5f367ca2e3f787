"""True disparity in pixels of the left image, whatever the scale of the file."""

import json

import cv2
import numpy as np
import pytest

from recon.errors import InputError
from recon.notices import collected_notices
from recon.records import Matches
from recon.sequences import read_truth
from recon.sequences.contradictions.truth import check_truth
from recon.sequences.pfm import write_pfm
from recon.sequences.truth import DisparityTruth, read_truth_file
from tests.sequences.recordings import DISPARITY_PX, write_pair_dir


def test_scale_is_read_from_the_meta_file(tmp_path):
    disparity, step = read_truth(write_pair_dir(tmp_path / "pair"))
    assert step == 1  # all values are integers
    assert np.isnan(disparity[:, :DISPARITY_PX]).all()
    np.testing.assert_array_equal(disparity[:, DISPARITY_PX:], DISPARITY_PX)


def test_given_scale_takes_precedence(tmp_path):
    disparity, step = read_truth(write_pair_dir(tmp_path / "pair"), truth_scale=32)
    assert step == 1 / 32
    assert np.nanmax(disparity) == DISPARITY_PX / 4


@pytest.mark.parametrize("ending", ["pfm", "tiff"])
def test_floats_are_pixels_and_non_finite_values_are_unknown(tmp_path, ending):
    stored = np.array([[1.5, np.inf, 0.0], [2.25, 3.0, -4.0]], np.float32)
    cv2.imwrite(str(tmp_path / f"disp_left.{ending}"), stored)
    disparity, step = read_truth(tmp_path)
    np.testing.assert_array_equal(disparity, [[1.5, np.nan, np.nan], [2.25, 3.0, -4.0]])
    assert step == 0


@pytest.mark.parametrize("meta", [None, {}, {"truth_scale": 0}, {"truth_scale": "much"}])
def test_integers_need_a_scale(tmp_path, meta):
    path = write_pair_dir(tmp_path / "pair")
    (path / "meta.json").unlink()
    if meta is not None:
        (path / "meta.json").write_text(json.dumps(meta))
    with pytest.raises(InputError, match="truth_scale"):
        read_truth(path)
    assert read_truth(path, truth_scale=7).quantisation_px == 1 / 7


def test_missing_or_broken_truth_is_rejected(tmp_path):
    with pytest.raises(InputError, match="holds no disp_left"):
        read_truth(tmp_path)
    (tmp_path / "disp_left.png").write_bytes(b"")
    with pytest.raises(InputError, match="not an image of disparities"):
        read_truth(tmp_path)


def test_written_disparity_is_read_back_as_truth(tmp_path):
    found = np.array([[1.5, np.nan, -3.25], [0.5, 20.0, np.nan]])
    write_pfm(tmp_path / "dense.pfm", found)
    again = read_truth_file(tmp_path / "dense.pfm")
    np.testing.assert_array_equal(again.disparity_px, found)
    assert again.quantisation_px == 0.0


def matches_at(disparity_px):
    """Make a match at every tenth pixel of a truth, with its expected disparity."""
    height, width = disparity_px.shape
    v, u = np.mgrid[:height:3, :width:3].reshape(2, -1)
    return Matches(
        points_px=np.column_stack([u, v]).astype(np.float64),
        index_left=np.arange(len(u)),
        index_right=np.arange(len(u)),
        disparity_px=disparity_px[v, u],
        sigma_px=np.ones(len(u)),
        score=np.ones(len(u)),
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda truth: truth, None),
        (lambda truth: truth + 0.4, None),
        (lambda truth: -truth, "with the truth times -1"),
        (lambda truth: truth / 16, "with the truth times 16"),
        (lambda truth: 4 * truth, "with the truth times 0.25"),
        (lambda truth: truth[::-1, ::-1] + 40, "is it the left image's, of these two"),
    ],
)
def test_truth_that_contradicts_the_matches_is_reported(change, words):
    true = 20.0 + 15.0 * np.random.default_rng(3).random((60, 80))
    image = np.zeros(true.shape, np.uint8)
    with collected_notices() as notices:
        check_truth(image, matches_at(true), DisparityTruth(change(true), 0.0))
    assert [notice.code for notice in notices] == (["truth-disagrees"] if words else [])
    assert all(words in notice.text for notice in notices)


@pytest.mark.parametrize("shape", [(59, 80), (60, 81)])
def test_truth_of_another_size_is_rejected(shape):
    image = np.zeros((60, 80), np.uint8)
    with pytest.raises(InputError, match="but the left image has 80 x 60"):
        check_truth(image, matches_at(np.ones((60, 80))), DisparityTruth(np.ones(shape), 0.0))


def sheets(side):
    """Make the true disparity of one image of three vertical sheets at 5, 20 and 35 px."""
    columns = np.arange(240)
    # In the left image the sheets begin at 0, 80 and 160.
    edges = [80, 160] if side == "left" else [60, 125]
    return np.tile(np.array([5.0, 20.0, 35.0])[np.digitize(columns, edges)], (60, 1))


@pytest.mark.parametrize(
    ("truth", "words"),
    [
        (sheets("left"), None),
        (sheets("right"), "the truth is the right image's"),
        (np.full((60, 240), 20.0), None),  # of one depth: left and right are indistinguishable
    ],
)
def test_truth_of_the_right_image_is_reported(truth, words):
    found = truth if words is None else sheets("left")
    image = np.zeros(truth.shape, np.uint8)
    matches = matches_at(found)
    inside = matches.points_px[:, 0] >= matches.disparity_px
    with collected_notices() as notices:
        check_truth(image, matches.select(inside), DisparityTruth(truth, 0.0))
    assert [words in notice.text for notice in notices] == ([True] if words else [])


def test_vertically_flipped_truth_is_reported():
    true = 20.0 + 15.0 * np.random.default_rng(3).random((60, 80))
    with collected_notices() as notices:
        check_truth(
            np.zeros(true.shape, np.uint8), matches_at(true), DisparityTruth(true[::-1], 0.0)
        )
    assert ["100% do with its rows upside down" in notice.text for notice in notices] == [True]
