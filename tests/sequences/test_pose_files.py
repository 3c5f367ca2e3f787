"""Poses in the files of many tools, matched to pairs by time, name or order."""

import json
import shutil

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.notices import collected_notices
from recon.sequences.pose_files import read_poses
from recon.sequences.posed_images import write_colmap, write_nerfstudio
from tests.sequences.read_back import DRIVEN, positions, read
from tests.sequences.recordings import (
    NUM_PAIRS,
    RIG,
    poses_recorded,
    random_poses,
    write_folder,
)


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


@pytest.mark.parametrize(("length", "is_said"), [(0.9999, False), (1.05, True)])
def test_quaternion_of_another_length_is_scaled_with_a_notice(tmp_path, length, is_said):
    (tmp_path / "poses.txt").write_text(f"0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 {length}\n")
    with collected_notices() as notices:
        np.testing.assert_allclose(read_poses(tmp_path / "poses.txt").poses[1], np.eye(4))
    assert [notice.code for notice in notices] == (["rotation-made-rigid"] if is_said else [])


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
