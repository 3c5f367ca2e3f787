"""Layouts, bags and poses of other recorders give the same four pairs."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.geometry import pose
from recon.notices import collected_notices
from recon.sequences import open_sequence
from recon.sequences.pose_files import read_poses
from recon.sequences.posed_images import write_colmap, write_nerfstudio
from recon.sequences.readers.bag import image_topics
from recon.sequences.readers.bag_messages import image
from recon.settings import SequenceSettings
from tests.sequences.recordings import (
    NUM_PAIRS,
    RIG,
    image_pairs,
    middlebury_keys,
    poses_recorded,
    write_euroc,
    write_folder,
    write_images,
    write_ros1,
    write_ros2,
    write_video,
)


def read(path, **settings):
    return list(open_sequence(path, SequenceSettings(**settings)))


def assert_same_pairs(pairs):
    assert len(pairs) == NUM_PAIRS
    for pair, (left, right) in zip(pairs, image_pairs(), strict=True):
        np.testing.assert_array_equal(pair.left if pair.left.ndim == 2 else pair.left[..., 0], left)
        np.testing.assert_array_equal(
            pair.right if pair.right.ndim == 2 else pair.right[..., 0], right
        )


def positions(path, **settings):
    return [pair.T_world_left[2, 3] for pair in read(path, **settings)]


DRIVEN = [0.0, -0.7, -1.4, -2.1]


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


# Poses


def tum(stamps):
    return "\n".join(f"{stamp} 0 0 {0.7 * n} 0 0 0 1" for n, stamp in enumerate(stamps))


@pytest.mark.parametrize("unit", [1, 10**3, 10**6, 10**9])
@pytest.mark.parametrize("start", [0, 1_403_636_579])
def test_poses_are_matched_by_time_in_any_unit(tmp_path, unit, start):
    path = write_folder(tmp_path / "recording")
    (path / "times.txt").write_text("\n".join(str(start + 0.1 * n) for n in range(NUM_PAIRS)))
    # Two poses per frame: only the time assigns them.
    stamps = [round((start + 0.05 * n) * unit, 3) for n in range(2 * NUM_PAIRS)]
    (path / "poses.txt").write_text(
        "\n".join(f"{stamp:.9f} 0 0 {0.35 * n} 0 0 0 1" for n, stamp in enumerate(stamps))
    )
    np.testing.assert_allclose(positions(path), DRIVEN, atol=1e-4)


def test_image_names_may_be_stamps(tmp_path):
    path = write_folder(tmp_path / "recording")
    stamps = [1403636579763555584 + 50_000_000 * n for n in range(NUM_PAIRS)]
    for side in ("left", "right"):
        for file, stamp in zip(sorted((path / side).iterdir()), stamps, strict=True):
            file.rename(file.with_name(f"{stamp}.png"))
    (path / "poses.txt").write_text(tum([f"{1e-9 * stamp:.6f}" for stamp in stamps]))
    np.testing.assert_allclose(positions(path), DRIVEN, atol=1e-4)


def test_poses_without_overlapping_times_are_rejected(tmp_path):
    path = write_folder(tmp_path / "recording")
    (path / "times.txt").write_text("\n".join(f"{100 + 0.1 * n}" for n in range(NUM_PAIRS)))
    (path / "poses.txt").write_text(tum([5000.0, 5000.1, 5000.2, 5000.3]))
    with pytest.raises(InputError, match="but overlapping times are needed"):
        read(path)


def test_pose_with_a_repeated_stamp_is_dropped_with_a_notice(tmp_path):
    (tmp_path / "poses.txt").write_text(tum([0.0, 0.1, 0.1, 0.2]))
    with collected_notices() as notices:
        assert len(read_poses(tmp_path / "poses.txt")) == 3
    assert [notice.code for notice in notices] == ["stamps-repeated"]
    assert "line 3" in notices[0].text


def random_poses():
    rng = np.random.default_rng(5)
    turns = Rotation.random(4, rng=rng).as_matrix()
    return np.stack([pose(R, t) for R, t in zip(turns, rng.normal(size=(4, 3)), strict=True)])


def rows_of(poses, form):
    for number, T in enumerate(poses):
        q, t = Rotation.from_matrix(T[:3, :3]).as_quat(), T[:3, 3]
        yield {
            "openvins": (number, *t, *q, *np.full(12, 1e-6)),
            "heading": (number, *q, *t),
            "vins": (number, *t, *np.roll(q, 1), 0, 0, 0),
            "kitti360": (number, *T[:3].ravel()),
        }[form]


@pytest.mark.parametrize(
    ("form", "separator", "heading"),
    [
        ("openvins", " ", "# timestamp(s) tx ty tz qx qy qz qw Pr11 Pr12 ..."),
        ("heading", " ", "# time q_x q_y q_z q_w p_x p_y p_z"),
        ("vins", ",", ""),
        ("kitti360", " ", ""),
    ],
)
def test_pose_columns_of_other_tools_are_read(tmp_path, form, separator, heading):
    lines = [separator.join(f"{v:.9f}" for v in row) for row in rows_of(random_poses(), form)]
    (tmp_path / "poses.txt").write_text("\n".join([heading, *lines]))
    np.testing.assert_allclose(read_poses(tmp_path / "poses.txt").poses, random_poses(), atol=1e-7)


def test_colmap_and_nerfstudio_poses_round_trip(tmp_path):
    names = [f"left/{n:06d}.png" for n in range(NUM_PAIRS)]
    write_colmap(tmp_path / "sparse", names, random_poses(), NUM_PAIRS * [RIG])
    write_nerfstudio(tmp_path / "transforms.json", names, random_poses(), NUM_PAIRS * [RIG])
    for path in (tmp_path / "sparse" / "images.txt", tmp_path / "transforms.json"):
        given = read_poses(path)
        assert given.names == tuple(names)
        np.testing.assert_allclose(given.poses, random_poses(), atol=1e-12)
    camera = (tmp_path / "sparse" / "cameras.txt").read_text().splitlines()[-1].split()
    # COLMAP's pixel (0, 0) is a corner.
    assert [float(v) for v in camera[4:]] == [80.0, 80.0, RIG.cx_left_px + 0.5, RIG.cy_px + 0.5]
    frames = json.loads((tmp_path / "transforms.json").read_text())["frames"]
    # OpenGL cameras look along -z.
    np.testing.assert_allclose(
        np.array(frames[0]["transform_matrix"])[:3, 2], -random_poses()[0][:3, 2]
    )


@pytest.mark.parametrize("file", ["images.txt", "transforms.json"])
def test_named_poses_are_matched_by_name(tmp_path, file):
    path = write_folder(tmp_path / "recording")
    (path / "poses.txt").unlink()
    names = [f"left/{n:06d}.png" for n in range(NUM_PAIRS)][::-1]
    poses = np.stack(poses_recorded())[::-1]
    if file == "images.txt":
        write_colmap(tmp_path / "sparse", names, poses, NUM_PAIRS * [RIG])
        shutil.copy(tmp_path / "sparse" / file, path / file)
    else:
        write_nerfstudio(path / file, names, poses, NUM_PAIRS * [RIG])
    np.testing.assert_allclose(positions(path), DRIVEN, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("poses.json", "{}"),
        ("poses.json", '{"frames": [{"file_path": "a", "transform_matrix": [[1, 2]]}]}'),
        ("poses.json", "[" * 100_000),
        ("poses.json", '{"frames": ' + "9" * 5000 + "}"),
        ("poses.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 7 0 0 0 0 0 0 1 b.png\n\n"),
        ("poses.txt", "0 0 0 0 0 0 0 0\n"),
    ],
)
def test_invalid_poses_are_rejected_in_one_line(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError) as caught:
        read_poses(tmp_path / name)
    assert "\n" not in str(caught.value)


# One pair


def test_single_pair_without_poses_is_level_with_y_up(tmp_path):
    path = write_folder(tmp_path / "recording")
    (path / "poses.txt").unlink()
    for side in ("left", "right"):
        for number in (1, 2, 3):
            (path / side / f"{number:06d}.png").unlink()
    for poses in ("given", "none"):
        (pair,) = read(path, poses=poses)
        np.testing.assert_array_equal(pair.T_world_left, np.diag([1.0, -1.0, -1.0, 1.0]))


# Bags


@pytest.mark.parametrize(
    ("topics", "found"),
    [
        (["/cam1/left", "/cam1/right"], ["/cam1/left", "/cam1/right"]),
        (["/camera/infra1/image_rect_raw", "/camera/infra2/image_rect_raw"], None),
        (["/cam0/image_raw", "/cam1/image_raw"], None),
        (["/cam1/image_raw", "/cam2/image_raw"], None),
        (["/zed/left/image_rect", "/zed/right/image_rect", "/zed/left/image_raw",
          "/zed/right/image_raw"], ["/zed/left/image_rect", "/zed/right/image_rect"]),
        (["/left/depth/image", "/left/rgb/image", "/right/rgb/image"],
         ["/left/rgb/image", "/right/rgb/image"]),
    ],
)  # fmt: skip
def test_topics_are_chosen_by_their_names(monkeypatch, topics, found):
    monkeypatch.setattr("recon.sequences.readers.bag.topics_of", lambda path, types: topics)
    chosen = image_topics(Path("bag"), SequenceSettings())
    assert [*chosen.values()] == (found or topics)


def test_ambiguous_topics_must_be_given(monkeypatch):
    topics = ["/a/image", "/b/image"]
    monkeypatch.setattr("recon.sequences.readers.bag.topics_of", lambda path, types: topics)
    with pytest.raises(InputError, match=r"/a/image, /b/image.*--left-topic"):
        image_topics(Path("bag"), SequenceSettings())
    asked = SequenceSettings(left_topic="/b/image", right_topic="/a/image")
    assert image_topics(Path("bag"), asked) == {"left": "/b/image", "right": "/a/image"}
    with pytest.raises(InputError, match="left topic is '/c', but one of /a/image"):
        image_topics(Path("bag"), SequenceSettings(left_topic="/c", right_topic="/a/image"))


def message(encoding, pixels, *, step=0, big=0):
    data = np.ascontiguousarray(pixels).view(np.uint8)
    rows = data.reshape(len(pixels), -1)
    padded = np.pad(rows, ((0, 0), (0, step)))
    return SimpleNamespace(
        encoding=encoding, height=pixels.shape[0], width=pixels.shape[1], is_bigendian=big,
        step=padded.shape[1], data=padded.ravel(),
    )  # fmt: skip


def test_encodings_of_bag_images_are_read():
    rng = np.random.default_rng(2)
    grey, rgb = rng.integers(0, 256, (4, 6), np.uint8), rng.integers(0, 256, (4, 6, 3), np.uint8)
    deep = rng.integers(0, 65536, (4, 6)).astype(np.uint16)
    alpha = np.full((4, 6, 1), 255, np.uint8)
    bgra = np.concatenate([rgb[..., ::-1], alpha], axis=2)
    for encoding, pixels, expected in (
        ("mono8", grey, grey), ("8UC1", grey, grey), ("rgb8", rgb, rgb),
        ("bgr8", rgb[..., ::-1], rgb), ("8UC3", rgb[..., ::-1], rgb), ("bgra8", bgra, rgb),
        ("8UC4", bgra, rgb), ("mono16", deep, deep), ("16UC1", deep, deep),
    ):  # fmt: skip
        np.testing.assert_array_equal(image(message(encoding, pixels)), expected)
        np.testing.assert_array_equal(image(message(encoding, pixels, step=8)), expected)
    swapped = deep.byteswap()
    np.testing.assert_array_equal(image(message("mono16", swapped, big=1)), deep)


def test_yuv_images_of_a_bag_are_read_and_unknown_encodings_rejected():
    yuyv = np.full((4, 6, 2), 128, np.uint8)
    yuyv[..., 0] = 90
    found = image(message("yuv422_yuy2", yuyv))
    assert found.shape == (4, 6, 3)
    assert np.ptp(found) <= 2
    with pytest.raises(InputError, match="encoded as 'my8', which is not known"):
        image(message("my8", np.zeros((2, 2), np.uint8)))
    broken = message("mono8", np.zeros((4, 6), np.uint8))
    broken.data = broken.data[:-1]
    with pytest.raises(InputError, match="has 23 bytes"):
        image(broken)


def test_compressed_images_of_a_bag_are_read():
    deep = np.linspace(0, 4000, 24).reshape(4, 6).astype(np.uint16)
    _, png = cv2.imencode(".png", deep)
    plain = SimpleNamespace(format="16UC1; png compressed", data=png.ravel())
    np.testing.assert_array_equal(image(plain), deep)
    data = np.concatenate([np.zeros(12, np.uint8), png.ravel()])
    depth = SimpleNamespace(format="16UC1; compressedDepth png", data=data)
    np.testing.assert_array_equal(image(depth), deep)


def test_single_ros_2_file_with_a_calibration_beside_it_is_read(tmp_path):
    path = write_ros2(tmp_path / "recording")
    (file,) = [one for one in path.iterdir() if one.suffix != ".yaml"]
    alone = tmp_path / "alone"
    alone.mkdir()
    shutil.copy(file, alone / file.name)
    (alone / "poses.txt").write_text((path.parent / "poses.txt").read_text())
    assert_same_pairs(read(alone / file.name))
    assert_same_pairs(read(alone))
    (alone / "calib.txt").write_text(middlebury_keys())
    assert open_sequence(alone / file.name, SequenceSettings()).disparity_range == (0, 16)
