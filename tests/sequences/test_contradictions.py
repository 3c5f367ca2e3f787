"""What images contradict is said with its code; sound ones get no word."""

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
from recon.sequences.contradictions.pairs import findings
from recon.sequences.images import read_image
from recon.sequences.pose_files import read_poses
from recon.settings import SequenceSettings
from recon.world.library import find_scene

NUM_PAIRS = 3
T_BODY_CAMERA = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
"""x forward, y left, z up."""


def textured(rng, shape=(240, 420)):
    """A smooth random image."""
    noise = cv2.GaussianBlur(rng.normal(size=shape), (0, 0), 2.0)
    return np.clip(128 + 90 * noise / noise.std() / 2, 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def images():
    """A pair whose halves are 12 and 5 px apart."""
    rng = np.random.default_rng(4)
    wide = textured(rng)
    upper, lower = wide[:120, 12:-8], wide[120:, 5:-15]
    return wide[:, :400].copy(), np.concatenate([upper, lower]).copy()


def codes(left, right, **known):
    return [finding.code for finding in findings(left, right, **known)]


def test_a_sound_pair_gets_no_word(images):
    assert codes(*images, search=(0, 20)) == []
    assert codes(*images) == []


def test_too_little_texture_tells_nothing():
    plain = np.full((120, 200), 90, np.uint8)
    other = plain.copy()
    other[0, 0] = 91
    assert codes(plain, other, search=(0, 5)) == []


@pytest.mark.parametrize("rows", [1, 2, -6])
def test_rows_that_do_not_correspond(images, rows):
    left, right = images
    assert codes(left, np.roll(right, rows, axis=0)) == ["rows-differ"]


def test_sides_that_are_swapped_or_mirrored(images):
    left, right = images
    assert codes(right, left, search=(0, 20)) == ["left-right-swapped"]
    assert codes(left[:, ::-1].copy(), right[:, ::-1].copy()) == ["left-right-swapped"]
    # Eyes that converge have negative disparities, and somebody who looks for them knows it.
    assert codes(right, left, search=(-20, 0)) == []


def test_a_range_that_leaves_out_what_is_there(images):
    assert codes(*images, search=(0, 8)) == ["search-range-too-small"]
    assert codes(*images, search=(8, 20)) == ["search-range-too-small"]


def test_images_that_have_nothing_in_common(images):
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


def test_a_pattern_that_repeats_is_not_of_another_place():
    bricks = np.tile(textured(np.random.default_rng(3), (40, 24)), (6, 20))
    assert codes(bricks[:, 5:405].copy(), bricks[:, 12:412].copy()) == []


@pytest.mark.parametrize(("gain", "offset"), [(0.4, 0), (0.5, 90), (1.6, -60)])
def test_a_camera_of_another_exposure_contradicts_nothing(images, gain, offset):
    left, right = images
    changed = np.clip(gain * right.astype(float) + offset, 0, 255).astype(np.uint8)
    assert codes(left, changed, search=(0, 20)) == []
    assert codes(changed, left, search=(0, 20)) == ["left-right-swapped"]


def test_cameras_at_another_angle_see_much_behind_infinity(images):
    left, right = images
    assert codes(left, np.roll(right, 8, axis=1)) == ["angle-differs"]
    assert codes(left, np.roll(right, -8, axis=1)) == []


@cache
def far_away():
    """A textured world."""
    return textured(np.random.default_rng(8), (300, 900))


def turning(rig, number):
    """What a rig that looks about sees of a textured world far away, both cameras alike."""
    moved = cv2.warpAffine(
        far_away(),
        np.array([[1.0, 0.0, -150.0 - 6.0 * number], [0.0, 1.0, -30.0 - 4.0 * number]]),
        (rig.width, rig.height),
        flags=cv2.INTER_LINEAR,
    )
    return moved, np.roll(moved, -9, axis=1)


def moving(num_pairs, late=0, still=False):
    """Pairs of such a rig; the right images show what the left ones did some pairs before."""
    rig = StereoRig(
        width=400, height=240, focal_px=400.0, cx_left_px=200.0, cx_right_px=200.0, cy_px=120.0,
        baseline=0.1,
    )  # fmt: skip
    for number in range(num_pairs):
        at = (0, 0) if still else (number, number - late)
        left, right = turning(rig, at[0])[0], turning(rig, at[1])[1]
        yield StereoPair(left=left, right=right, rig=rig, name=f"{number:06d}")


@pytest.mark.parametrize(
    ("late", "words"), [(1, "1 pair late"), (2, "2 pairs late"), (-1, "1 pair early")]
)
def test_a_camera_that_lags_is_told_by_the_pairs_before(late, words):
    *before, last = moving(3, late)
    found = moment_finding(last, before[::-1])
    assert found.code == "not-simultaneous"
    assert words in found.text


@pytest.mark.parametrize("still", [False, True])
def test_cameras_of_one_moment_do_not_lag_moving_or_at_rest(still):
    *before, last = moving(3, still=still)
    assert moment_finding(last, before[::-1]) is None


class Listed(list):
    """Pairs as a source has them."""

    disparity_range = None
    skipped = ()


def test_sides_that_are_swapped_only_from_the_middle_on_are_told():
    def pairs(swapped):
        for number, pair in enumerate(moving(12)):
            is_swapped = number in swapped
            sides = (pair.right, pair.left) if is_swapped else (pair.left, pair.right)
            yield replace(pair, left=sides[0], right=sides[1])

    def told(swapped):
        with collected_notices() as notices:
            source = Listed(pairs(swapped))
            assert len(list(CheckedPairs(source, has_given_poses=False))) == 12
        return [notice.code for notice in notices]

    assert told(range(6, 12)) == ["left-right-swapped"]
    assert told(range(12)) == ["left-right-swapped"]
    assert told([9]) == []


def test_one_image_on_both_sides(images):
    assert codes(images[0], images[0].copy()) == ["same-image"]


def drive(data_dir, path, *, first=20, sides=("left", "right"), late=0, rows=0, poses=None):
    """Some pairs of the recorded drive, changed."""
    recorded = data_dir / "kitti_odometry" / "sequence_1"
    for side, source, shift in zip(("left", "right"), sides, (0, late), strict=True):
        (path / side).mkdir(parents=True)
        for number in range(NUM_PAIRS):
            image = cv2.imread(str(recorded / source / f"{first + number + shift:06d}.png"), -1)
            moved = np.roll(image, rows if side == "right" else 0, axis=0)
            cv2.imwrite(str(path / side / f"{number:06d}.png"), moved)
    (path / "calib.txt").write_text((recorded / "calib.txt").read_text())
    given = read_poses(recorded / "poses.txt").poses[first : first + NUM_PAIRS]
    changed = given if poses is None else poses(given)
    rows_of_text = (" ".join(f"{v:.9e}" for v in T[:3].ravel()) for T in changed)
    (path / "poses.txt").write_text("\n".join(rows_of_text))
    return path


def said(path, **settings):
    with collected_notices() as notices:
        assert len(list(open_sequence(path, SequenceSettings(**settings)))) == NUM_PAIRS
    return {notice.code: notice.text for notice in notices}


@pytest.mark.data
def test_a_sound_drive_gets_no_word(data_dir, tmp_path):
    assert said(drive(data_dir, tmp_path / "later")) == {}


@pytest.mark.data
def test_pairs_of_the_drive_that_contradict_what_is_said_of_them(data_dir, tmp_path):
    swapped = drive(data_dir, tmp_path / "swapped", sides=("right", "left"))
    assert [*said(swapped)] == ["left-right-swapped"]
    assert [*said(drive(data_dir, tmp_path / "rows", rows=2))] == ["rows-differ"]
    assert [*said(drive(data_dir, tmp_path / "late", late=1))] == ["not-simultaneous"]
    assert [*said(drive(data_dir, tmp_path / "early", late=-1))] == ["not-simultaneous"]


@pytest.mark.data
@pytest.mark.parametrize(
    ("change", "word"),
    [
        (np.linalg.inv, "inverted"),
        (lambda T: T @ np.linalg.inv(T_BODY_CAMERA), "axes are not the camera's"),
        (lambda T: T[::-1], "opposite order"),
        (lambda T: _scaled(T, 1000.0), "with positions times 0.001"),  # in millimetres
        (lambda T: _scaled(T, 1.3), "with positions times 0.77"),
    ],
)
def test_poses_of_another_kind_than_the_images_show(data_dir, tmp_path, change, word):
    path = drive(data_dir, tmp_path / "drive", poses=change)
    found = said(path)
    assert [*found] == ["poses-disagree"]
    assert word in found["poses-disagree"]
    if change is np.linalg.inv:
        assert said(path, poses="estimated") == {}


def _scaled(poses, factor):
    far = poses.copy()
    far[:, :3, 3] *= factor
    return far


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "highest"), [("2001/venus", 20), ("2003/cones", 60), ("2005/Moebius", 80)]
)
def test_recorded_pairs_get_no_word_until_they_are_spoilt(data_dir, name, highest):
    folder = data_dir / f"middlebury{name}"
    left, right = (read_image(folder / f"{side}.png") for side in ("left", "right"))
    assert codes(left, right, search=(0, highest)) == []
    assert codes(right, left, search=(0, highest)) == ["left-right-swapped"]
    assert "rows-differ" in codes(left, np.roll(right, 2, axis=0), search=(0, highest))


@pytest.mark.data
def test_poses_that_go_wrong_on_the_way_are_said(data_dir, tmp_path, monkeypatch):
    monkeypatch.setattr("tests.sequences.test_contradictions.NUM_PAIRS", 16)

    def turned_round(poses):
        return np.concatenate([poses[:12], poses[12:][::-1]])

    found = said(drive(data_dir, tmp_path / "drive", first=0, poses=turned_round))
    assert [*found] == ["poses-disagree"]
    assert "near 0000" in found["poses-disagree"]


def test_bricks_that_look_the_same_after_a_turn_do_not_contradict_the_poses(tmp_path):
    """Round a tower of bricks 18 degrees are nearly the pitch of its pattern."""
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
