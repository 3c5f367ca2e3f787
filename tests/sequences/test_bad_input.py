"""Faulty frames of a recording are skipped if possible, and counted with their reason."""

import shutil

import cv2
import numpy as np
import pytest

from recon.errors import InputError
from recon.sequences import open_sequence
from recon.settings import SequenceSettings
from tests.sequences.read_back import positions
from tests.sequences.recordings import (
    DISPARITY_PX,
    NUM_PAIRS,
    RIG,
    kitti_poses,
    middlebury_keys,
    write_euroc,
    write_folder,
    write_video,
)


@pytest.fixture
def folder(tmp_path):
    return write_folder(tmp_path / "recording")


def read(path, **settings):
    """Read a recording; return the names of its pairs and the skipped frames."""
    source = open_sequence(path, SequenceSettings(**settings))
    pairs = list(source)
    for pair in pairs:
        assert_sides_match(pair)
    return [pair.name for pair in pairs], dict(source.skipped)


def assert_sides_match(pair):
    left, right = pair.left[:, DISPARITY_PX:], pair.right[:, :-DISPARITY_PX]
    np.testing.assert_array_equal(left, right)


@pytest.mark.parametrize("side", ["left", "right"])
def test_unpaired_image_is_skipped_and_other_poses_are_kept(folder, side):
    (folder / side / "000001.png").unlink()
    names, skipped = read(folder)
    assert names == ["000000", "000002", "000003"]
    assert skipped == {"000001": f"it has no {side} image"}
    np.testing.assert_allclose(positions(folder), [0, -1.4, -2.1], atol=1e-8)


def test_frame_missing_on_both_sides_does_not_shift_poses(folder):
    for side in ("left", "right"):
        (folder / side / "000001.png").unlink()
    names, skipped = read(folder)
    assert names == ["000000", "000002", "000003"]
    assert skipped == {"000001": "it is in neither folder"}
    np.testing.assert_allclose(positions(folder), [0, -1.4, -2.1], atol=1e-8)


def test_differently_named_sides_are_paired_by_number(folder):
    for side in ("left", "right"):
        for file in (folder / side).iterdir():
            file.rename(file.with_name(f"{side}{int(file.stem):d}.png"))
    (folder / "right" / "right2.png").unlink()
    names, skipped = read(folder)
    assert names == ["0", "1", "3"]
    assert skipped == {"2": "it has no right image"}


def test_unnumbered_images_must_be_equally_many_on_both_sides(folder):
    for number, file in enumerate(sorted((folder / "right").iterdir())):
        file.rename(file.with_name("abcd"[number] + ".png"))
    assert read(folder)[0] == ["000000", "000001", "000002", "000003"]
    (folder / "right" / "b.png").unlink()
    with pytest.raises(InputError, match=r"has 4 images and .* 3 with other names"):
        read(folder)


def test_images_of_a_different_size_are_skipped(folder):
    for side in ("left", "right"):
        cv2.imwrite(str(folder / side / "000002.png"), np.zeros((32, 48), np.uint8))
    names, skipped = read(folder)
    assert names == ["000000", "000001", "000003"]
    assert skipped == {"000002": "the left image has 48 x 32 pixels, but 96 x 64 are needed"}


def test_pairs_of_different_sizes_are_skipped(folder):
    cv2.imwrite(str(folder / "right" / "000000.png"), np.zeros((32, 48), np.uint8))
    names, skipped = read(folder)
    assert len(names) == NUM_PAIRS - 1
    assert "the right image has 48 x 32" in skipped["000000"]


def test_truncated_png_is_skipped_without_library_output(folder, capfd):
    file = folder / "left" / "000002.png"
    file.write_bytes(file.read_bytes()[:500])
    names, skipped = read(folder)
    assert names == ["000000", "000001", "000003"]
    assert skipped == {"000002": f"{file} is cut short, but a whole image is needed"}
    assert capfd.readouterr().err == ""


def test_skipped_frame_is_reported_once(folder, caplog):
    (folder / "left" / "000002.png").write_bytes(b"")
    source = open_sequence(folder, SequenceSettings())
    for _ in range(2):
        list(source)
        assert len(source.skipped) == 1
    (record,) = caplog.records
    assert record.args[0] == "frames-skipped"


def test_frames_with_decreasing_stamps_are_skipped(folder):
    (folder / "times.txt").write_text("0.0\n0.5\n0.4\n0.6\n")
    names, skipped = read(folder)
    assert names == ["000000", "000001", "000003"]
    assert skipped == {"000002": "its time 0.4 s is not after the 0.5 s of 000001"}


def test_too_few_given_poses_are_rejected(folder):
    (folder / "poses.txt").write_text("\n".join(kitti_poses().splitlines()[:2]))
    with pytest.raises(InputError, match=r"2 poses for 4 frames \(000000"):
        read(folder)
    assert len(read(folder, poses="none")[0]) == NUM_PAIRS


def test_frames_outside_the_time_of_the_poses_are_skipped(folder):
    (folder / "poses.txt").write_text("1 0 0 0.7 0 0 0 1\n2 0 0 1.4 0 0 0 1\n")
    (folder / "times.txt").write_text("0\n1\n2\n3\n")
    names, skipped = read(folder)
    assert names == ["000001", "000002"]
    assert skipped == dict.fromkeys(["000000", "000003"], "there is no pose for it")


def test_surplus_poses_need_numbered_images(folder):
    for side in ("left", "right"):
        for number, file in enumerate(sorted((folder / side).iterdir())):
            file.rename(file.with_name("abcd"[number] + ".png"))
        (folder / side / "b.png").unlink()
    with pytest.raises(InputError, match=r"4 poses for 3 frames \(a"):
        read(folder)


def test_calibration_for_another_image_size_is_rejected(folder):
    (folder / "calib.txt").write_text(middlebury_keys().replace("width=96", "width=192"))
    with pytest.raises(InputError, match=r"96 x 64 pixels, but the left .*192 x 64 pixels"):
        read(folder)


@pytest.mark.parametrize("is_stated", [False, True])
def test_principal_point_outside_the_image_is_rejected(folder, is_stated):
    """Calibrations that state the image size, and calibrations that do not."""
    calib = folder / "calib.txt"
    if is_stated:
        calib.write_text(middlebury_keys())
    calib.write_text(calib.read_text().replace("47.0", "147.0"))
    with pytest.raises(InputError, match="principal point at 147, 31"):
        read(folder)


def test_swapped_cameras_are_rejected(folder):
    calib = folder / "calib.txt"
    calib.write_text("\n".join(reversed(calib.read_text().splitlines())))
    with pytest.raises(InputError, match=r"is 0\.5 to the left"):
        read(folder)


def test_folder_without_calibration_is_rejected(folder):
    (folder / "calib.txt").unlink()
    with pytest.raises(InputError, match="holds no calibration"):
        read(folder)


def test_recording_without_readable_images_is_rejected(folder):
    for file in folder.glob("*/*.png"):
        file.write_bytes(b"no image")
    with pytest.raises(InputError, match=r"no image can be read.*000000\.png"):
        read(folder)


def test_unpaired_euroc_images_are_skipped(tmp_path):
    path = write_euroc(tmp_path / "recording")
    table = path / "mav0/cam1/data.csv"
    table.write_text(table.read_text().replace("2000000000,000002.png\n", ""))
    names, skipped = read(path)
    assert names == ["0", "1000000000", "3000000000"]
    assert skipped == {"2000000000": "it has no right image"}


def test_invalid_line_of_an_image_table_is_named(tmp_path):
    path = write_euroc(tmp_path / "recording")
    (path / "mav0/cam1/data.csv").write_text("#timestamp [ns],filename\n0,000000.png\nsoon,b.png")
    with pytest.raises(InputError, match=r"data\.csv, line 3: 'soon,b\.png'"):
        read(path)


def test_truncated_video_is_read_up_to_its_end(tmp_path):
    path = write_video(tmp_path / "recording")
    file = path / "right.avi"
    file.write_bytes(file.read_bytes()[: int(0.7 * file.stat().st_size)])
    names, skipped = read(path)
    assert 0 < len(names) < NUM_PAIRS
    assert len(names) + len(skipped) == NUM_PAIRS


def test_invalid_video_is_rejected(tmp_path):
    path = write_video(tmp_path / "recording")
    (path / "left.avi").write_bytes(b"no video")
    with pytest.raises(InputError, match="is not a video that OpenCV can read"):
        read(path)


@pytest.mark.parametrize("form", ["auto", "folder"])
def test_topics_are_rejected_for_a_recording_without_topics(folder, form):
    with pytest.raises(InputError, match="has no topics, but '/cam0' was asked for"):
        read(folder, left_topic="/cam0", format=form)


def test_invalid_stamps_are_rejected(folder):
    (folder / "times.txt").write_text("0\nnan\n2\n3\n")
    with pytest.raises(InputError, match=r"times\.txt holds nan"):
        read(folder)
    (folder / "times.txt").write_text("0\nsoon\n2\n3\n")
    with pytest.raises(InputError, match=r"times\.txt, line 2: 'soon' is not a time"):
        read(folder)


def test_zero_baseline_is_rejected_with_the_file_name(folder):
    text = middlebury_keys().replace(f"baseline={1000 * RIG.baseline}", "baseline=0")
    (folder / "calib.txt").write_text(text)
    with pytest.raises(InputError, match=r"calib\.txt: both cameras have the same position"):
        read(folder)


def test_first_reason_is_given_if_no_pair_can_be_read(folder):
    shutil.rmtree(folder / "right")
    shutil.copytree(folder / "left", folder / "right")
    for path in (folder / "right").iterdir():
        cv2.imwrite(str(path), cv2.imread(str(path))[:10])
    with pytest.raises(InputError, match="the first is 000000: the right image has 96 x 10 pixels"):
        read(folder)


def test_folder_of_images_is_rejected_with_the_known_layouts(folder):
    with pytest.raises(InputError, match=r"is not a known recording .* left/, right/ and calib"):
        read(folder / "left")
