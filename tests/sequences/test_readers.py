"""Every format of recording gives the same pairs through `open_sequence`."""

from dataclasses import astuple
from importlib.metadata import EntryPoint

import numpy as np
import pytest

from recon.errors import InputError
from recon.sequences import open_sequence
from recon.sequences.open import READERS
from recon.sequences.readers.reader import Reader
from recon.settings import SequenceSettings
from tests.sequences.recordings import (
    NUM_PAIRS,
    RIG,
    image_pairs,
    poses_recorded,
    write_euroc,
    write_folder,
    write_kitti,
    write_pair_dir,
    write_ros1,
    write_ros2,
    write_simulated,
    write_video,
)

WRITERS = {
    "folder": write_folder,
    "kitti": write_kitti,
    "euroc": write_euroc,
    "video": write_video,
    "ros1": write_ros1,
    "ros2": write_ros2,
    "simulated": write_simulated,
}
UP = np.diag([1.0, -1.0, -1.0, 1.0])


@pytest.fixture(params=WRITERS)
def recording(request, tmp_path):
    return WRITERS[request.param](tmp_path / "recording")


def test_format_is_detected_and_gives_the_same_pairs(recording):
    source = open_sequence(recording, SequenceSettings())
    pairs = list(source)
    assert len(source) == len(pairs) == NUM_PAIRS
    assert list(source.skipped) == []
    for number, (pair, (left, right)) in enumerate(zip(pairs, image_pairs(), strict=True)):
        np.testing.assert_allclose(astuple(pair.rig), astuple(RIG), rtol=1e-12)
        assert pair.stamp_s == number
        np.testing.assert_array_equal(_grey(pair.left), left)
        np.testing.assert_array_equal(_grey(pair.right), right)


def test_poses_have_y_up(recording):
    """The rig drives along its z axis, which is -z in the rotated world."""
    pairs = list(open_sequence(recording, SequenceSettings()))
    for pair, T_recorded_left in zip(pairs, poses_recorded(), strict=True):
        np.testing.assert_allclose(pair.T_world_left, UP @ T_recorded_left, atol=1e-8)
    np.testing.assert_allclose(pairs[-1].T_world_left[:3, 3], [0, 0, -2.1], atol=1e-12)
    assert pairs[0].T_world_left[1, 1] == pytest.approx(-1)  # its y, down, is the world's -y


def test_source_can_be_iterated_again(recording):
    source = open_sequence(recording, SequenceSettings())
    first, again = ([pair.left for pair in source] for _ in range(2))
    np.testing.assert_array_equal(first, again)


def test_every_n_reads_every_nth_pair(recording):
    source = open_sequence(recording, SequenceSettings(every=3))
    assert [pair.stamp_s for pair in source] == [0.0, 3.0]
    assert len(source) == 2


def test_poses_none_leaves_poses_out(recording):
    pairs = list(open_sequence(recording, SequenceSettings(poses="none")))
    assert [pair.T_world_left for pair in pairs] == [None] * NUM_PAIRS


def test_region_crops_both_images_and_moves_the_principal_points(recording):
    whole, part = (
        next(iter(open_sequence(recording, SequenceSettings(roi=roi))))
        for roi in (None, (10, 5, 50, 40))
    )
    np.testing.assert_array_equal(part.left, whole.left[5:45, 10:60])
    np.testing.assert_array_equal(part.right, whole.right[5:45, 10:60])
    point = np.array([[0.3, -0.2, 4.0]])
    np.testing.assert_allclose(
        part.rig.project_left(point) + np.array([10, 5]), whole.rig.project_left(point), atol=1e-12
    )
    assert part.rig.disparity(4.0) == whole.rig.disparity(4.0)


def test_region_outside_the_image_is_rejected(tmp_path):
    path = write_folder(tmp_path / "recording")
    with pytest.raises(InputError, match=r"roi is 90,0,10,10, but a part of 96 x 64"):
        list(open_sequence(path, SequenceSettings(roi=(90, 0, 10, 10))))


def test_single_pair_is_at_the_origin_and_has_a_search_range(tmp_path):
    source = open_sequence(write_pair_dir(tmp_path / "pair"), SequenceSettings())
    (pair,) = source
    np.testing.assert_array_equal(pair.T_world_left, UP)
    assert pair.name == "pair"
    assert source.disparity_range == (0, 16)


def test_several_pairs_need_poses(tmp_path):
    path = write_folder(tmp_path / "recording")
    (path / "poses.txt").unlink()
    with pytest.raises(InputError, match=r"000000 has no pose.*--poses estimated"):
        list(open_sequence(path, SequenceSettings()))
    assert len(list(open_sequence(path, SequenceSettings(poses="none")))) == NUM_PAIRS


def test_kitti_poses_are_moved_to_the_left_colour_camera(tmp_path):
    path = write_kitti(tmp_path / "recording")
    (path / "image_0").rename(path / "image_2")
    (path / "image_1").rename(path / "image_3")
    f, cx, cy = RIG.focal_px, RIG.cx_left_px, RIG.cy_px
    rows = [f"P{n}: {f} 0 {cx} {-f * x} 0 {f} {cy} 0 0 0 1 0" for n, x in
            enumerate([0, 0.5, 0.06, 0.6])]  # fmt: skip
    (path / "calib.txt").write_text("\n".join(rows))
    pair = next(iter(open_sequence(path, SequenceSettings())))
    np.testing.assert_allclose(pair.T_world_left[:3, 3], [0.06, 0, 0], atol=1e-12)
    assert pair.rig.baseline == pytest.approx(0.54)


def test_kitti_poses_are_found_in_the_layout_of_the_dataset(tmp_path):
    path = write_kitti(tmp_path / "dataset" / "sequences" / "05")
    (tmp_path / "dataset" / "poses").mkdir()
    (path / "poses.txt").rename(tmp_path / "dataset" / "poses" / "05.txt")
    assert len(list(open_sequence(path, SequenceSettings()))) == NUM_PAIRS


def test_side_by_side_video_is_split(tmp_path):
    import cv2

    path = write_video(tmp_path / "recording")
    film = cv2.VideoWriter(
        str(path / "both.avi"), cv2.VideoWriter_fourcc(*"FFV1"), 1.0, (2 * RIG.width, RIG.height)
    )
    for pair in image_pairs():
        film.write(cv2.cvtColor(np.hstack(pair), cv2.COLOR_GRAY2BGR))
    film.release()
    pairs = list(open_sequence(path / "both.avi", SequenceSettings()))
    for pair, (left, right) in zip(pairs, image_pairs(), strict=True):
        np.testing.assert_array_equal(_grey(pair.left), left)
        np.testing.assert_array_equal(_grey(pair.right), right)


def test_unknown_recording_is_rejected(tmp_path):
    with pytest.raises(InputError, match="is not a known recording"):
        open_sequence(tmp_path, SequenceSettings())
    with pytest.raises(InputError, match="does not exist"):
        open_sequence(tmp_path / "nothing", SequenceSettings())
    with pytest.raises(InputError, match="left is not a folder"):
        open_sequence(tmp_path, SequenceSettings(format="folder"))


def test_plugin_reader_is_used(tmp_path, monkeypatch):
    register_plugins(monkeypatch, mine="tests.sequences.test_readers:MINE")
    path = write_folder(tmp_path / "recording")
    (path / "left").rename(path / "links")
    (path / "mine").touch()
    with pytest.raises(InputError, match="left is not a folder"):
        open_sequence(path, SequenceSettings())


@pytest.mark.parametrize("value", ["no_such_module:X", "tests.sequences.test_readers:BROKEN"])
def test_broken_plugin_does_not_affect_other_readers(tmp_path, monkeypatch, value):
    register_plugins(monkeypatch, broken=value)
    path = write_folder(tmp_path / "recording")
    assert len(list(open_sequence(path, SequenceSettings()))) == NUM_PAIRS
    with pytest.raises(InputError, match="is not a known recording"):
        open_sequence(path / "left", SequenceSettings())


def register_plugins(monkeypatch, **values):
    entries = [EntryPoint(name, value, "recon.sequences") for name, value in values.items()]
    monkeypatch.setattr("recon.plugins.entry_points", lambda group: entries)


def _fail(path):
    raise RuntimeError("a fault of somebody else's")


MINE = Reader(fits=lambda path: (path / "mine").exists(), open=READERS.load("folder").open)
BROKEN = Reader(fits=_fail, open=_fail)


def _grey(image):
    return image if image.ndim == 2 else image[..., 0]


def test_folder_that_may_not_be_read_is_named_once(tmp_path, monkeypatch, caplog):
    def refused(path):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("recon.sequences.readers.folder._sides", refused)
    with pytest.raises(PermissionError, match=str(tmp_path)):
        open_sequence(tmp_path, SequenceSettings())
    assert not caplog.records


def test_nested_folder_that_may_not_be_read_does_not_hide_the_recording(tmp_path, monkeypatch):
    write_folder(tmp_path / "disk" / "recording")
    (tmp_path / "disk" / "lost+found").mkdir()
    monkeypatch.setattr("os.access", lambda path, mode: path.name != "lost+found")
    opened = open_sequence(tmp_path / "disk", SequenceSettings())
    assert len(opened) == NUM_PAIRS


def test_plug_ins_are_looked_for_once_however_many_folders_are_searched(tmp_path, monkeypatch):
    for number in range(20):
        (tmp_path / f"{number}" / "inner").mkdir(parents=True)
    calls = []
    monkeypatch.setattr("recon.plugins.entry_points", lambda group: calls.append(group) or [])
    with pytest.raises(InputError, match="is not a known recording"):
        open_sequence(tmp_path, SequenceSettings())
    assert calls.count("recon.sequences") <= 2
