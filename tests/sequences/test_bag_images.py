"""Topics and images of bags."""

import shutil
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from recon.errors import InputError
from recon.sequences import open_sequence
from recon.sequences.readers.bag import image_topics
from recon.sequences.readers.bag_messages import image
from recon.settings import SequenceSettings
from tests.sequences.read_back import assert_same_pairs, read
from tests.sequences.recordings import (
    middlebury_keys,
    write_ros2,
)


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
