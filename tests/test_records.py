"""Records reject invalid values, survive pickling, and do not modify their inputs."""

import pickle

import numpy as np
import pytest

from recon.camera import StereoRig
from recon.errors import InputError, check_finite, check_shape
from recon.geometry import pose, rotation_about_y
from recon.records import (
    Cone,
    FoundObject,
    Matches,
    Part,
    PointCloud,
    Recognition,
    StereoPair,
    Trajectory,
    TruncatedCone,
    View,
)
from recon.records.objects import as_json, from_json
from recon.records.solids import from_parameters

RIG = StereoRig(
    width=6, height=4, focal_px=5.0, cx_left_px=2.5, cx_right_px=2.5, cy_px=1.5, baseline=1.0
)


def grey(height=4, width=6):
    return np.zeros((height, width), dtype=np.uint8)


def test_probable_matches_are_not_more_likely_wrong():
    number = np.array([3.0, 2.0, 1.0])
    matches = Matches(
        points_px=np.zeros((3, 2)), disparity_px=number, sigma_px=number, score=number,
        probability=np.array([0.6, 0.4, np.nan]),
    )  # fmt: skip
    assert matches.probable().disparity_px.tolist() == [3.0, 1.0]


def test_pair_survives_pickling():
    pair = StereoPair(left=grey(), right=grey(), rig=RIG, T_world_left=np.eye(4), name="a")
    copy = pickle.loads(pickle.dumps(pair))
    assert copy.rig == pair.rig
    assert np.array_equal(copy.left, pair.left)


@pytest.mark.parametrize(
    ("left", "right", "message"),
    [
        (grey(), grey(4, 5), r"left image has shape \(4, 6\), right \(4, 5\)"),
        (grey().astype(float), grey(), "left image is float64, but uint8 is needed"),
        (np.zeros((4, 6, 4), np.uint8), grey(), r"\(4, 6, 4\)"),
        (grey(5, 6), grey(5, 6), "is 6 x 5 pixels, but its calibration is for 6 x 4"),
        (grey(0, 6), grey(0, 6), r"\(0, 6\)"),
    ],
)
def test_inconsistent_pair_is_rejected(left, right, message):
    with pytest.raises(InputError, match=message):
        StereoPair(left=left, right=right, rig=RIG, name="pair 7")


def test_view_takes_focal_length_or_field_of_view():
    with pytest.raises(InputError, match="one follows from the other"):
        View(position=[0, 5, 0], target=[0, 5, -9], focal_length=0.1, fov_deg=80.0)


def test_transformed_cloud_keeps_colours_and_sigma():
    rng = np.random.default_rng(5)
    points = rng.normal(size=(9, 3))
    points.flags.writeable = False
    cloud = PointCloud(points=points, colours=np.full((9, 3), 7, np.uint8), sigma=np.ones(9))
    T = pose(rotation_about_y(0.3), [1, 2, 3])
    moved = cloud.transformed(T)
    np.testing.assert_allclose(moved.points, points @ T[:3, :3].T + [1, 2, 3], atol=1e-12)
    assert moved.colours is cloud.colours
    assert moved.sigma is cloud.sigma


@pytest.mark.parametrize("dtype", [">f8", ">f4", "f2", "i2", "u1", "longdouble"])
def test_numbers_of_a_cloud_are_native_floats(dtype):
    numbers = np.array([[1, 2, 3], [4, 5, 6]], dtype)
    values = np.array([1, 2], ">i4")
    cloud = PointCloud(points=numbers, sigma=numbers[:, 0], attributes={"class": values})
    for floats in (cloud.points, cloud.sigma):
        assert floats.dtype in (np.dtype("f4"), np.dtype("f8"))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.attributes["class"].dtype == np.dtype("i4")
    kept = np.zeros((2, 3), np.float32)
    assert PointCloud(points=kept).points is kept


def test_array_of_the_wrong_shape_is_named():
    with pytest.raises(InputError, match=r"colours has shape \(2, 3\), but \(3, 3\) is needed"):
        PointCloud(points=np.zeros((3, 3)), colours=np.zeros((2, 3), np.uint8))


def test_checks_state_name_value_and_requirement():
    with pytest.raises(InputError, match=r"disparity_px has shape \(4,\), but \(3,\) is needed"):
        check_shape("disparity_px", np.zeros(4), (3,))
    with pytest.raises(InputError, match="depth holds nan at flat index 2"):
        check_finite("depth", np.array([0.0, 1.0, np.nan]))


def test_objects_round_trip_through_json():
    cone = TruncatedCone(
        point=np.array([1.0, 8, 3]), axis=np.array([0.0, 1, 0]), radius_bottom=7.0, radius_top=1.0,
        height=4.0,
    )  # fmt: skip
    tip = Cone(apex=np.ones(3), axis=np.array([0.0, -1, 0]), half_angle_rad=np.pi / 4, height=2.0)
    parts = tuple(
        Part(role=role, solid=solid, hue_deg=12.5, num_voxels=9, rms=0.1)
        for role, solid in (("crown", cone), ("body", tip))
    )
    found = FoundObject(
        id=0, label="cottage", probability=0.75, centre=np.array([1.0, 5.5, 3]),
        size=np.array([14.0, 11, 14]), num_voxels=50, views=9, parts=parts,
    )  # fmt: skip
    label = np.zeros(50, np.int32)
    document = as_json(Recognition(objects=(found,), label=label))
    again = Recognition(objects=from_json(document), label=label)
    assert as_json(again) == document
    assert document["objects"][0]["parts"][1]["parameters"]["half_angle_deg"] == 45.0


def test_unknown_shape_is_rejected():
    with pytest.raises(InputError, match="torus with"):
        from_parameters("torus", {"radius": 1.0})


@pytest.mark.parametrize(
    ("row", "fault"),
    [
        ("1 0 0", "'1 0 0', but eight numbers are needed"),
        ("1 0 0 0 0 0 0 one", "'1 0 0 0 0 0 0 one', but eight numbers are needed"),
        ("1 0 0 nan 0 0 0 1", "'1 0 0 nan 0 0 0 1', but eight numbers are needed"),
        ("1 0 0 0 0 0 0 1 9", "'1 0 0 0 0 0 0 1 9', but eight numbers are needed"),
    ],
)
def test_faulty_row_of_a_trajectory_is_named(row, fault):
    whole = "# stamp x y z qx qy qz qw\n0 0 0 0 0 0 0 1\n\n"
    assert Trajectory.from_tum(whole).stamps_s.tolist() == [0]
    with pytest.raises(InputError, match=f"way.txt, line 4: {fault}"):
        Trajectory.from_tum(whole + row, "way.txt")


@pytest.mark.parametrize("document", [{"objects": 3}, [], {"objects": [3]}])
def test_objects_of_the_wrong_type_are_damaged_and_lack_no_key(document):
    with pytest.raises(InputError, match=r"objects\.json is damaged"):
        from_json(document)
