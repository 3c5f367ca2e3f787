"""Calibration files of other tools are told by their content, or rejected in one line."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.notices import collected_notices
from recon.sequences.calibration.files import read_calibration

CAMERA = "  camera_model: pinhole\n  distortion_model: {model}\n  distortion_coeffs: {lens}\n"
CAMERA += "  intrinsics: [458.6, 457.3, 367.2, 248.4]\n  resolution: [752, 480]\n"
IDENTITY = "[[1.0, 0.0, 0.0, {x}], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0, 0, 0, 1]]"


def kalibr(
    step, *, model="radtan", lens="[0, 0, 0, 0]", comment="# of the lab, for twelve words\n"
):
    """Write a chain of two cameras 0.11 apart; `step` is the key that states their distance."""
    camera = CAMERA.format(model=model, lens=lens)
    places = {
        "T_cn_cnm1": (None, "-0.11"), "T_cam_imu": ("0.05", "-0.06"), "T_imu_cam": ("0.05", "0.16")
    }[step]  # fmt: skip
    rows = [f"  {step}: {IDENTITY.format(x=x)}\n" if x else "" for x in places]
    return f"{comment}cam0:\n{camera}{rows[0]}cam1:\n{camera}{rows[1]}"


def matrix(name, rows, cols, data, form="%YAML:1.0"):
    return f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: {data}\n"


K = [450.0, 0.0, 320.0, 0.0, 450.0, 240.0, 0.0, 0.0, 1.0]
IDENTITY_3X3 = [1.0, 0, 0, 0, 1, 0, 0, 0, 1]
CAMERAS = "".join(matrix(f"M{n}", 3, 3, K) + matrix(f"D{n}", 1, 5, [0.0] * 5) for n in (1, 2))
STEP = matrix("R", 3, 3, IDENTITY_3X3) + matrix("T", 3, 1, [-0.12, 0.0, 0.0])
HEAD = "%YAML:1.0\n---\n"


def camera_info(side, case=str.upper):
    """Write a ROS message as its tools print it; version 2 uses lower case."""
    K, R = [500.0, 0, 320, 0, 500, 240, 0, 0, 1], [1.0, 0, 0, 0, 1, 0, 0, 0, 1]
    P = [500.0, 0, 320, 0.0 if side == "left" else -60.0, 0, 500, 240, 0, 0, 0, 1, 0]
    fields = {"D": [0.0] * 5, "K": K, "R": R, "P": P}
    rows = "".join(f"{case(name)}: {values}\n" for name, values in fields.items())
    return f"header: {{seq: 1}}\nheight: 480\nwidth: 640\ndistortion_model: plumb_bob\n{rows}---\n"


def ros(side):
    x = -54.0 if side == "right" else 0.0
    return (
        f"image_width: 640\nimage_height: 480\ncamera_name: narrow_stereo/{side}\n"
        f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: {K}\ndistortion_model: plumb_bob\n"
        "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.0, 0.0, 0.0, 0.0, 0.0]\n"
        f"rectification_matrix:\n  rows: 3\n  cols: 3\n  data: {IDENTITY_3X3}\n"
        f"projection_matrix:\n  rows: 3\n  cols: 4\n  data: [450.0, 0.0, 320.0, {x}, 0.0, 450.0,"
        " 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]\n"
    )


ORB = (
    "Camera.fx: 435.2\nCamera.fy: 435.2\nCamera.cx: 367.4\nCamera.cy: 252.2\nCamera.k1: 0.0\n"
    "Camera.width: 752\nCamera.height: 480\nCamera.bf: 47.872\n"
)
ORB3 = (
    'File.version: "1.0"\nCamera.type: "PinHole"\n'
    + "".join(
        f"Camera{n}.fx: 458.6\nCamera{n}.fy: 457.3\nCamera{n}.cx: 367.2\nCamera{n}.cy: 248.4\n"
        f"Camera{n}.k1: -0.28\nCamera{n}.k2: 0.07\nCamera{n}.p1: 0.0002\nCamera{n}.p2: 1.8e-05\n"
        for n in (1, 2)
    )
    + "Camera.width: 752\nCamera.height: 480\n"
    + matrix("Stereo.T_c1_c2", 4, 4, [1, 0, 0, 0.11, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1.0])
)
OKVIS = "cameras:\n" + "".join(
    f"     - {{T_SC:\n        [1, 0, 0, {x},\n         0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],\n"
    "        image_dimension: [752, 480],\n        distortion_coefficients: [-0.28, 0.07, 0, 0],\n"
    "        distortion_type: radialtangential,\n        focal_length: [458.6, 457.3],\n"
    "        principal_point: [367.2, 248.4]}\n"
    for x in (0.05, 0.16)
)
VINS = (
    HEAD
    + 'imu: 1\ncam0_calib: "cam0_pinhole.yaml"\ncam1_calib: "cam1_pinhole.yaml"\n'
    + "".join(
        matrix(f"body_T_cam{n}", 4, 4, [1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1.0])
        for n, x in ((0, 0.05), (1, 0.16))
    )
)
VINS_CAMERA = (
    HEAD + "model_type: PINHOLE\ncamera_name: camera\nimage_width: 752\nimage_height: 480\n"
    "distortion_parameters:\n   k1: -0.28\n   k2: 0.07\n   p1: 0.0\n   p2: 0.0\n"
    "projection_parameters:\n   fx: 458.6\n   fy: 457.3\n   cx: 367.2\n   cy: 248.4\n"
)
XML = (
    '<?xml version="1.0"?>\n<opencv_storage>\n<image_width>640</image_width>'
    "<image_height>480</image_height>\n"
    + "".join(
        f'<{name} type_id="opencv-matrix"><rows>{rows}</rows><cols>{cols}</cols><dt>d</dt>'
        f"<data>{' '.join(str(v) for v in data)}</data></{name}>\n"
        for name, rows, cols, data in (
            ("K1", 3, 3, K), ("D1", 1, 5, [0.0] * 5), ("K2", 3, 3, K), ("D2", 1, 5, [0.0] * 5),
            ("R", 3, 3, IDENTITY_3X3), ("T", 3, 1, [-0.12, 0, 0]),
        )
    )
    + "</opencv_storage>\n"
)  # fmt: skip
PROJECTION = "{name}: 721.5377 0 609.5593 {x} 0 721.5377 172.854 0 0 0 1 0\n"
RAW = "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.950000e-02\n" + "".join(
    f"S_0{n}: 1.392e+03 5.12e+02\nK_0{n}: 984 0 690 0 980 233 0 0 1\nS_rect_0{n}: 1242 375\n"
    "R_rect_0{n}: 1 0 0 0 1 0 0 0 1\n" + PROJECTION.format(name=f"P_rect_0{n}", x=x)
    for n, x in enumerate((0, -387.5744, 44.85728, -339.5242))
)
STEREO_2012 = "".join(
    PROJECTION.format(name=f"P{n}", x=x) for n, x in enumerate((0, -387.5744, 44.85728, -339.5242))
)


@pytest.mark.parametrize(
    ("files", "given", "baseline"),
    [
        ({"chain.yaml": kalibr("T_cn_cnm1")}, "chain.yaml", 0.11),
        ({"chain.yaml": kalibr("T_cam_imu")}, "chain.yaml", 0.11),
        ({"chain.yaml": HEAD + kalibr("T_imu_cam", comment="")}, "chain.yaml", 0.11),
        ({"chain.yaml": kalibr("T_cn_cnm1", model="equidistant")}, "chain.yaml", 0.11),
        ({"intrinsics.yml": HEAD + CAMERAS, "extrinsics.yml": HEAD + STEP}, "intrinsics.yml", 0.12),
        ({"intrinsics.yml": HEAD + CAMERAS, "extrinsics.yml": HEAD + STEP}, "extrinsics.yml", 0.12),
        ({"intrinsics.yml": HEAD + CAMERAS, "extrinsics.yml": HEAD + STEP}, ".", 0.12),
        ({"left.yaml": ros("left"), "right.yaml": ros("right")}, "left.yaml", 0.12),
        ({"left.yaml": ros("left"), "right.yaml": ros("right")}, "right.yaml", 0.12),
        (
            {"left.yaml": camera_info("left"), "right.yaml": camera_info("right")},
            "left.yaml",
            0.12,
        ),
        (
            {
                "left.yaml": camera_info("left", str.lower),
                "right.yaml": camera_info("right", str.lower),
            },
            "left.yaml",
            0.12,
        ),
        ({"calib.xml": XML}, "calib.xml", 0.12),
        ({"EuRoC.yaml": HEAD + ORB}, "EuRoC.yaml", 0.11),
        ({"EuRoC.yaml": HEAD + ORB3}, "EuRoC.yaml", 0.11),
        ({"config.yaml": "%YAML:1.0\n" + OKVIS}, "config.yaml", 0.11),
        ({"rig.yaml": VINS, "cam0_pinhole.yaml": VINS_CAMERA, "cam1_pinhole.yaml": VINS_CAMERA},
         "rig.yaml", 0.11),
        ({"calib_cam_to_cam.txt": RAW}, "calib_cam_to_cam.txt", 0.53715),
        ({"000000.txt": STEREO_2012}, "000000.txt", 0.53715),
    ],
)  # fmt: skip
def test_calibration_format_is_detected_from_its_content(tmp_path, files, given, baseline):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with collected_notices() as notices:
        rig = read_calibration(tmp_path / given)
    assert rig.baseline == pytest.approx(baseline, rel=2e-4)
    assert rig.T_right_left[0, 3] < 0
    assert notices == []


@pytest.mark.parametrize("text", [RAW, STEREO_2012], ids=["raw", "2012"])
def test_kitti_colour_cameras_have_another_baseline(tmp_path, text):
    (tmp_path / "calib.txt").write_text(text)
    assert read_calibration(tmp_path / "calib.txt", (2, 3)).baseline == pytest.approx(
        0.53273, rel=2e-5
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0.1 0 1 0 0 0 0 1 0.7\n", "holds poses"),
        ("1.0 0 0 0 0 0 0 1\n2.0 0 0 1 0 0 0 1\n", "holds no keys"),
        ("cam0: hello\ncam1: {T_cn_cnm1: 3}\n", "cam0 is a str, but keys are needed"),
        (ros("left"), "no file of the other side"),
        (XML.replace("<data>450.0", "<data>45x"), "not a calibration in XML"),
        ('<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "XML entities"),
        ("<a>" * 5000, "not a calibration in XML"),
        ("a: " + "[" * 5000, "for a calibration"),
        ("a: &a [1,1,1,1,1,1,1,1,1,1]\n"
         + "".join(f"{chr(98 + n)}: &{chr(98 + n)} [{','.join([f'*{chr(97 + n)}'] * 10)}]\n"
                   for n in range(8)), "for a calibration"),
        ("K1: " + "9" * 5000, "more than 400 digits"),
        (VINS.replace("cam0_pinhole.yaml", "../secret.yaml"), "outside its folder"),
        (kalibr("T_cn_cnm1").replace("[1.0, 0.0, 0.0, -0.11]", "[1.5, 0.0, 0.0, -0.11]"),
         "not a rotation"),
        (kalibr("T_cn_cnm1", model="fov"), "camera model pinhole with fov is not known"),
    ],
)  # fmt: skip
def test_invalid_calibration_is_rejected_in_one_line(tmp_path, text, message):
    (tmp_path / "calib.yaml").write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        read_calibration(tmp_path / "calib.yaml")
    assert "\n" not in str(caught.value)


def test_rounded_rotation_is_made_rigid_with_a_notice(tmp_path):
    turned = kalibr("T_cn_cnm1").replace(
        "[[1.0, 0.0, 0.0, -0.11], [0.0, 1.0", "[[0.99995, 0.0, 0.0, -0.11], [0.0, 1.0"
    )
    (tmp_path / "chain.yaml").write_text(turned)
    with collected_notices() as notices:
        rig = read_calibration(tmp_path / "chain.yaml")
    np.testing.assert_allclose(rig.T_right_left[:3, :3], np.eye(3), atol=1e-12)
    assert [notice.code for notice in notices] == ["rotation-made-rigid"]


@pytest.mark.parametrize("name", ["SN10027507.conf", "rig.npz"])
def test_calibration_of_another_kind_is_refused_with_the_known_ones(tmp_path, name):
    (tmp_path / name).write_bytes(b"[LEFT_CAM_HD]\nfx=700.819\n")
    said = f"{name} is not a calibration of a known kind .*OpenCV, ROS, Kalibr"
    for path in (tmp_path, tmp_path / name):
        with pytest.raises(InputError, match=said):
            read_calibration(path)
