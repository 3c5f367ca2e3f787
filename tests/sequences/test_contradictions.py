"""Contradictions in images are reported with a code; correct images give no findings."""

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest

from recon.camera import StereoRig
from recon.notices import collected_notices
from recon.records import StereoPair
from recon.runs.execute import execute
from recon.runs.job import Job
from recon.sequences import open_sequence
from recon.sequences.contradictions.checked import CheckedPairs
from recon.sequences.contradictions.moments import moment_finding
from recon.sequences.contradictions.pairs import check_range, findings
from recon.sequences.images import read_image
from recon.settings import SequenceSettings
from recon.world.library import find_scene


def textured(rng, shape=(240, 420)):
    """Make a smooth random image."""
    noise = cv2.GaussianBlur(rng.normal(size=shape), (0, 0), 2.0)
    return np.clip(128 + 90 * noise / noise.std() / 2, 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def images():
    """A pair whose upper and lower halves have disparities of 12 and 5 px."""
    rng = np.random.default_rng(4)
    wide = textured(rng)
    upper, lower = wide[:120, 12:-8], wide[120:, 5:-15]
    return wide[:, :400].copy(), np.concatenate([upper, lower]).copy()


def codes(left, right, **known):
    return [finding.code for finding in findings(left, right, **known)]


def test_correct_pair_gives_no_findings(images):
    assert codes(*images, search=(0, 20)) == []
    assert codes(*images) == []


def test_untextured_pair_gives_no_findings():
    plain, other = np.full((2, 120, 200), 90, np.uint8)
    plain[0, 0], other[0, 0] = 92, 91
    assert codes(plain, other, search=(0, 5)) == []


@pytest.mark.parametrize("rows", [1, 2, -6])
def test_row_offset_is_reported(images, rows):
    left, right = images
    assert codes(left, np.roll(right, rows, axis=0)) == ["rows-differ"]


def test_swapped_or_mirrored_sides_are_reported(images):
    left, right = images
    assert codes(right, left, search=(0, 20)) == ["left-right-swapped"]
    assert codes(left[:, ::-1].copy(), right[:, ::-1].copy()) == ["left-right-swapped"]
    # Converging cameras have negative disparities, and a negative search range expects them.
    assert codes(right, left, search=(-20, 0)) == []


def test_too_small_search_range_is_reported(images):
    assert codes(*images, search=(0, 8)) == ["search-range-too-small"]
    assert codes(*images, search=(8, 20)) == ["search-range-too-small"]


def test_search_range_alone_is_reported_unless_something_else_explains_it(images):
    left, right = images
    with collected_notices():
        assert check_range(left, right, (0, 8)) == {"search-range-too-small"}
        assert check_range(left, right, (0, 20)) == frozenset()
        assert check_range(right, left, (0, 20)) == frozenset()
        assert check_range(left, left, (8, 20)) == frozenset()


def test_unrelated_images_are_reported(images):
    left, right = images
    assert codes(left, right[::-1, ::-1].copy()) == ["images-unrelated"]
    assert codes(left, textured(np.random.default_rng(9))[:, :400].copy()) == ["images-unrelated"]


def test_noise_over_weak_texture_does_not_make_images_unrelated():
    def noisy(texture):
        return np.clip(texture + rng.normal(0, 3, texture.shape), 0, 255).astype(np.uint8)

    def smooth():
        texture = cv2.GaussianBlur(rng.normal(size=(300, 420)), (0, 0), 5)
        return 120 + 4 * texture / texture.std()

    rng = np.random.default_rng(3)
    one, other = smooth(), smooth()
    left = noisy(one[:, :400])
    assert codes(left, noisy(one[:, 6:406])) == []
    assert codes(left, noisy(other[:, :400])) == ["images-unrelated"]


def test_repetitive_pattern_is_not_reported_as_unrelated():
    bricks = np.tile(textured(np.random.default_rng(3), (40, 24)), (6, 20))
    assert codes(bricks[:, 5:405].copy(), bricks[:, 12:412].copy()) == []


@pytest.mark.parametrize(("gain", "offset"), [(0.4, 0), (0.5, 90), (1.6, -60)])
def test_exposure_difference_is_not_reported(images, gain, offset):
    left, right = images
    changed = np.clip(gain * right.astype(float) + offset, 0, 255).astype(np.uint8)
    assert codes(left, changed, search=(0, 20)) == []
    assert codes(changed, left, search=(0, 20)) == ["left-right-swapped"]


def test_angle_between_cameras_is_reported_by_negative_disparities(images):
    left, right = images
    assert codes(left, np.roll(right, 8, axis=1)) == ["angle-differs"]
    assert codes(left, np.roll(right, -8, axis=1)) == []


@cache
def distant_world():
    """Make the image of a distant, textured world."""
    return textured(np.random.default_rng(8), (300, 900))


def rotating_pair(rig, number):
    """Render a rotating rig's pair of a distant world, the same in both cameras but for a shift."""
    moved = cv2.warpAffine(
        distant_world(),
        np.array([[1.0, 0.0, -150.0 - 6.0 * number], [0.0, 1.0, -30.0 - 4.0 * number]]),
        (rig.width, rig.height),
        flags=cv2.INTER_LINEAR,
    )
    return moved, np.roll(moved, -9, axis=1)


def rotating_pairs(num_pairs, late=0, still=False):
    """Yield pairs of such a rig; the right images lag by `late` pairs."""
    rig = StereoRig(
        width=400, height=240, focal_px=400.0, cx_left_px=200.0, cx_right_px=200.0, cy_px=120.0,
        baseline=0.1,
    )  # fmt: skip
    for number in range(num_pairs):
        at = (0, 0) if still else (number, number - late)
        left, right = rotating_pair(rig, at[0])[0], rotating_pair(rig, at[1])[1]
        yield StereoPair(left=left, right=right, rig=rig, name=f"{number:06d}")


@pytest.mark.parametrize(
    ("late", "words"), [(1, "1 pair late"), (2, "2 pairs late"), (-1, "1 pair early")]
)
def test_lagging_camera_is_reported_by_earlier_pairs(late, words):
    *before, last = rotating_pairs(3, late)
    found = moment_finding(last, before[::-1])
    assert found.code == "not-simultaneous"
    assert words in found.text


@pytest.mark.parametrize("still", [False, True])
def test_synchronised_cameras_are_not_reported(still):
    *before, last = rotating_pairs(3, still=still)
    assert moment_finding(last, before[::-1]) is None


def test_motion_along_the_baseline_is_not_reported():
    """Its images have corresponding rows, whichever are paired; the nearest share most corners."""
    wide = textured(np.random.default_rng(4), (240, 700))
    rig = StereoRig(
        width=400, height=240, focal_px=400.0, cx_left_px=200.0, cx_right_px=200.0, cy_px=120.0,
        baseline=2.0,
    )  # fmt: skip
    *before, last = (
        StereoPair(
            left=wide[:, at : at + 400], right=wide[:, at + 160 : at + 560], rig=rig, name=""
        )
        for at in range(0, 3 * 40, 40)
    )
    assert moment_finding(last, before[::-1]) is None


class Listed(list):
    """A list of pairs with the attributes of a source."""

    disparity_range = None
    skipped = ()


def test_sides_swapped_from_the_middle_on_are_reported():
    def pairs(swapped):
        for number, pair in enumerate(rotating_pairs(12)):
            is_swapped = number in swapped
            sides = (pair.right, pair.left) if is_swapped else (pair.left, pair.right)
            yield replace(pair, left=sides[0], right=sides[1])

    def notices_for(swapped):
        with collected_notices() as notices:
            source = Listed(pairs(swapped))
            assert len(list(CheckedPairs(source, has_given_poses=False))) == 12
        return [notice.code for notice in notices]

    assert notices_for(range(6, 12)) == ["left-right-swapped"]
    assert notices_for(range(12)) == ["left-right-swapped"]
    assert notices_for([9]) == []


def test_same_image_on_both_sides_is_reported(images):
    assert codes(images[0], images[0].copy()) == ["same-image"]


@pytest.mark.parametrize("level", [0, 90])
def test_blank_images_are_reported_as_such(images, level):
    blank = np.full_like(images[0], level)
    for pair, sides in (
        ((blank, blank), "left and right images are blank"),
        ((images[0], blank), "right image is blank"),
        ((blank, images[1]), "left image is blank"),
    ):
        (finding,) = findings(*pair)
        assert finding.code == "image-blank"
        assert sides in finding.text


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "highest"), [("2001/venus", 20), ("2003/cones", 60), ("2005/Moebius", 80)]
)
def test_recorded_pairs_are_reported_only_when_corrupted(data_dir, name, highest):
    folder = data_dir / f"middlebury{name}"
    left, right = (read_image(folder / f"{side}.png") for side in ("left", "right"))
    assert codes(left, right, search=(0, highest)) == []
    assert codes(right, left, search=(0, highest)) == ["left-right-swapped"]
    assert "rows-differ" in codes(left, np.roll(right, 2, axis=0), search=(0, highest))


def test_rotationally_repetitive_bricks_do_not_contradict_the_poses(tmp_path):
    """The bricks of a round tower repeat after nearly 18 degrees."""
    angles = np.radians(18.0 * np.arange(6))
    places = [18.36, 14.06, 18.36] * np.column_stack([np.sin(angles), np.ones(6), np.cos(angles)])
    np.savetxt(tmp_path / "views.txt", np.hstack([places, np.tile([0.0, 5.5, 0.0], (6, 1))]))
    views = str(tmp_path / "views.txt")
    execute(
        Job(kind="render", inputs=(find_scene("cottage"),), arguments={"views": views}),
        tmp_path / "ring",
    )
    poses = tmp_path / "ring/poses.txt"
    rows = poses.read_text().splitlines()

    def codes_of():
        with collected_notices() as notices:
            assert len(list(open_sequence(tmp_path / "ring", SequenceSettings()))) == 6
        return [notice.code for notice in notices]

    assert codes_of() == []
    poses.write_text("\n".join([rows[n] for n in (0, 2, 4, 1, 3, 5)]))
    assert codes_of() == ["poses-disagree"]
