"""Layouts of other recorders give the same four pairs, read as a whole or in parts."""

import shutil

import cv2
import numpy as np
import pytest

from recon.errors import InputError
from recon.sequences import open_sequence
from recon.settings import SequenceSettings
from tests.sequences.read_back import assert_same_pairs, read
from tests.sequences.recordings import (
    NUM_PAIRS,
    RIG,
    image_pairs,
    write_euroc,
    write_folder,
    write_images,
    write_ros1,
    write_ros2,
    write_video,
)


def raw_calibration(cameras):
    f, cx, cy = RIG.focal_px, RIG.cx_left_px, RIG.cy_px
    return "calib_time: 09-Jan-2012 13:57:47\n" + "".join(
        f"S_rect_0{n}: {RIG.width} {RIG.height}\nR_rect_0{n}: 1 0 0 0 1 0 0 0 1\n"
        f"P_rect_0{n}: {f} 0 {cx} {-f * x} 0 {f} {cy} 0 0 0 1 0\n"
        for n, x in enumerate(cameras)
    )


@pytest.mark.parametrize(
    ("sides", "baseline"), [(("image_02", "image_03"), 0.54), (("image_00", "image_01"), 0.5)]
)
def test_raw_kitti_drive_has_its_calibration_in_the_parent_folder(tmp_path, sides, baseline):
    drive = tmp_path / "2011_09_26" / "2011_09_26_drive_0001_sync"
    write_images(drive / sides[0] / "data", drive / sides[1] / "data")
    (drive.parent / "calib_cam_to_cam.txt").write_text(raw_calibration([0, 0.5, 0.06, 0.6]))
    stamps = [f"2011-09-26 13:02:2{n}.964389445" for n in range(NUM_PAIRS)]
    (drive / sides[0] / "timestamps.txt").write_text("\n".join(stamps))
    pairs = read(drive, poses="none")
    assert_same_pairs(pairs)
    assert pairs[0].rig.baseline == pytest.approx(baseline)
    np.testing.assert_allclose(np.diff([pair.stamp_s for pair in pairs]), 1.0, atol=1e-6)
    assert len(read(tmp_path / "2011_09_26", poses="none")) == NUM_PAIRS


def test_kitti_stereo_set_has_one_calibration_per_scene(tmp_path):
    write_images(tmp_path / "image_2", tmp_path / "image_3")
    for side in ("image_2", "image_3"):
        for file in (tmp_path / side).iterdir():
            file.rename(file.with_name(f"{file.stem}_10.png"))
    (tmp_path / "calib_cam_to_cam").mkdir()
    for number in range(NUM_PAIRS):
        text = raw_calibration([0, 0.5, 0.06, 0.6 + 0.1 * number])
        (tmp_path / "calib_cam_to_cam" / f"{number:06d}.txt").write_text(text)
    pairs = read(tmp_path, poses="none")
    assert_same_pairs(pairs)
    np.testing.assert_allclose([pair.rig.baseline for pair in pairs], [0.54, 0.64, 0.74, 0.84])


def test_folder_with_a_single_recording_is_that_recording(tmp_path):
    write_folder(tmp_path / "outer" / "inner")
    assert_same_pairs(read(tmp_path / "outer"))
    write_folder(tmp_path / "outer" / "other")
    with pytest.raises(InputError, match="contains 2 recordings"):
        read(tmp_path / "outer")


@pytest.mark.parametrize("sides", [("Left", "Right"), ("cam0", "cam1"), ("infra1", "infra2")])
def test_other_names_of_the_image_folders_are_known(tmp_path, sides):
    write_folder(tmp_path / "drive")
    for old, new in zip(("left", "right"), sides, strict=True):
        (tmp_path / "drive" / old).rename(tmp_path / "drive" / new)
    assert_same_pairs(read(tmp_path / "drive"))


def test_folder_with_a_single_video_is_that_video(tmp_path):
    path = write_video(tmp_path / "clip")
    both = [np.hstack(pair) for pair in image_pairs()]
    for side in ("left", "right"):
        (path / f"{side}.avi").unlink()
    video = cv2.VideoWriter(
        str(path / "any name.avi"), cv2.VideoWriter_fourcc(*"FFV1"), 1.0, both[0].shape[::-1]
    )
    for frame in both:
        video.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    video.release()
    assert_same_pairs(read(path))


def test_jittering_stamps_are_not_gaps(tmp_path):
    path = write_euroc(tmp_path / "recording")
    stamps = [1403636579763555584, 1403636579813555456, 1403636579863555584, 1403636579913555328]
    for camera in ("cam0", "cam1"):
        names = [f"{stamp},{n:06d}.png" for n, stamp in enumerate(stamps)]
        (path / "mav0" / camera / "data.csv").write_text("\n".join(names))
    shutil.rmtree(path / "mav0" / "state_groundtruth_estimate0")
    source = open_sequence(path, SequenceSettings(poses="none"))
    assert len(list(source)) == NUM_PAIRS
    assert list(source.skipped) == []


def test_slice_is_read_without_earlier_frames(tmp_path):
    path = write_folder(tmp_path / "recording")
    whole = read(path)
    for side in ("left", "right"):
        (path / side / "000001.png").write_bytes(b"damaged")
    part = open_sequence(path, SequenceSettings())[2:4]
    assert len(part) == 2
    assert [pair.name for pair in part] == ["000002", "000003"]
    first = next(iter(part))
    np.testing.assert_array_equal(first.left, whole[2].left)
    np.testing.assert_allclose(first.T_world_left, whole[2].T_world_left)


@pytest.mark.parametrize("write", [write_video, write_ros1, write_ros2])
def test_videos_and_bags_can_be_sliced(tmp_path, write):
    source = open_sequence(write(tmp_path / "recording"), SequenceSettings())
    whole = list(source)
    part = list(source[1:3])
    assert [pair.name for pair in part] == [pair.name for pair in whole[1:3]]
    np.testing.assert_array_equal(part[0].left, whole[1].left)


def test_single_pair_without_poses_is_level_with_y_up(tmp_path):
    path = write_folder(tmp_path / "recording")
    (path / "poses.txt").unlink()
    for side in ("left", "right"):
        for number in (1, 2, 3):
            (path / side / f"{number:06d}.png").unlink()
    for poses in ("given", "none"):
        (pair,) = read(path, poses=poses)
        np.testing.assert_array_equal(pair.T_world_left, np.diag([1.0, -1.0, -1.0, 1.0]))
