"""Given poses in every format, at any time, in a world with y up."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.geometry import pose
from recon.sequences.pose_files import read_poses
from recon.sequences.poses import GivenPoses, T_up_recorded
from recon.sequences.timestamps import list_frame_poses
from tests.sequences.recordings import random_poses

rotations = st.tuples(*[st.floats(-3, 3)] * 3).map(lambda v: Rotation.from_rotvec(v).as_matrix())


def write(path, form, poses):
    quaternions = Rotation.from_matrix(poses[:, :3, :3]).as_quat()
    if form == "kitti":
        rows = [" ".join(f"{v:.9f}" for v in T[:3].ravel()) for T in poses]
    elif form == "tum":
        rows = ["# stamp tx ty tz qx qy qz qw"] + [
            " ".join(f"{v:.9f}" for v in (n, *T[:3, 3], *q))
            for n, (T, q) in enumerate(zip(poses, quaternions, strict=True))
        ]
    else:
        rows = ["#timestamp, position, quaternion wxyz, velocity"] + [
            ",".join(f"{v:.9f}" for v in (n * 1e9, *T[:3, 3], *np.roll(q, 1), 0, 0, 0))
            for n, (T, q) in enumerate(zip(poses, quaternions, strict=True))
        ]
    path.write_text("\n".join(rows))
    return path


@pytest.mark.parametrize("form", ["kitti", "tum", "euroc"])
def test_all_formats_give_the_same_poses(tmp_path, form):
    trajectory = read_poses(write(tmp_path / "poses.txt", form, random_poses()))
    np.testing.assert_allclose(trajectory.poses, random_poses(), atol=1e-7)
    if form == "kitti":
        assert trajectory.stamps_s is None
    else:
        np.testing.assert_allclose(trajectory.stamps_s, [0, 1, 2, 3])


def test_spaces_and_a_comment_do_not_matter(tmp_path):
    path = write(tmp_path / "poses.txt", "kitti", random_poses())
    path.write_text("# poses\n" + path.read_text().replace(" ", "   ") + "  \n\n")
    assert len(read_poses(path)) == 4


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 0 0 0 0 1 0 0 0 0 1 0\n1 2 3\n", r"line 2: rows have \[3, 12\] numbers"),
        ("1 0 0 0 0 1 0 0 0 0 1 nan\n", "line 1: .* but finite numbers are needed"),
        ("0 0 0 0 0 0 0 1\nzero\n", "line 2: 'zero', but finite"),
        ("2 0 0 0 0 2 0 0 0 0 2 0\n", r"line 1: the pose is not a rotation .*off by 3\)"),
        ("1 0 0 0 0 1 0 0 0 0 -1 0\n", r"line 1: the pose is not .*\(it mirrors\)"),
        (
            "1 0 0 0 0 0 0 1\n0.5 0 0 0 0 0 0 1\n",
            "line 2: the time is before that of the previous row",
        ),
        ("# nothing\n", "holds no pose"),
    ],
)
def test_invalid_pose_is_named_by_its_line(tmp_path, text, message):
    path = tmp_path / "poses.txt"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_poses(path)


@settings(max_examples=30)
@given(rotations)
def test_conversion_to_y_up_uses_right_angles_and_keeps_the_camera_upright(rotation):
    turn = T_up_recorded(pose(rotation, [1.0, 2.0, 3.0]))
    assert set(np.unique(np.abs(turn))) <= {0.0, 1.0}
    assert np.linalg.det(turn[:3, :3]) == pytest.approx(1)
    np.testing.assert_array_equal(turn[:3, 3], 0)
    up_world = turn[:3, :3] @ -rotation[:, 1]
    assert up_world[1] == np.abs(up_world).max()  # nearer to y than to any other axis


def test_world_with_y_up_is_kept_and_kitti_is_rotated():
    upright = np.diag([1.0, -1.0, -1.0, 1.0])
    np.testing.assert_array_equal(T_up_recorded(upright), np.eye(4))
    np.testing.assert_array_equal(T_up_recorded(np.eye(4)), upright)


def test_poses_are_interpolated_between_stamps():
    turns = Rotation.from_rotvec([[0, 0, 0], [0, 0.4, 0]]).as_matrix()
    ends = np.stack([pose(R, t) for R, t in zip(turns, ([0, 0, 0], [1, 2, 3]), strict=True)])
    trajectory = GivenPoses(poses=ends, stamps_s=np.array([10.0, 10.2]))
    middle = trajectory.at(10.05)
    np.testing.assert_allclose(middle[:3, 3], [0.25, 0.5, 0.75])
    np.testing.assert_allclose(middle[:3, :3], Rotation.from_rotvec([0, 0.1, 0]).as_matrix())
    np.testing.assert_array_equal(trajectory.at(10.2), ends[1])
    assert trajectory.at(9.9) is None
    assert trajectory.at(10.3) is None


def test_poses_are_not_interpolated_over_long_gaps():
    trajectory = GivenPoses(poses=np.stack([np.eye(4)] * 2), stamps_s=np.array([0.0, 3.0]))
    assert trajectory.at(1.5) is None
    assert trajectory.at(3.0) is not None


@pytest.mark.parametrize(
    ("names", "num_rows", "rows"),
    [
        (["a", "b", "c"], 3, [0, 1, 2]),
        (["0", "10", "20"], 3, [0, 1, 2]),
        (["0", "2", "3"], 4, [0, 2, 3]),
        (["100", "101", "103"], 4, [0, 1, 3]),
        (["100", "101", "103"], 200, [100, 101, 103]),
        (["img_5", "img_6"], 7, [5, 6]),
    ],
)
def test_rows_of_poses_are_assigned_to_frames(names, num_rows, rows):
    times = 10.0 * np.arange(num_rows)
    frame_poses = list_frame_poses(names, times, None)
    assert [frame_pose.stamp_s for frame_pose in frame_poses] == [10.0 * row for row in rows]
