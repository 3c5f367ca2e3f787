"""Calibration files of every format give the same rig; invalid values are named."""

import numpy as np
import pytest

from recon.camera import TYPICAL_RESIDUAL_PX
from recon.errors import InputError
from recon.sequences.calibration.chains import read_sensors
from recon.sequences.calibration.files import read_calibration

K_LEFT = np.array([[458.654, 0, 367.215], [0, 457.296, 248.375], [0, 0, 1]])
K_RIGHT = np.array([[457.587, 0, 379.999], [0, 456.134, 255.238], [0, 0, 1]])
D_LEFT, D_RIGHT = [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05], [-0.28, 0.07, -1e-4, -3e-5]
ANGLE = 0.014
R = np.array([[1, 0, 0], [0, np.cos(ANGLE), np.sin(ANGLE)], [0, -np.sin(ANGLE), np.cos(ANGLE)]])
T = np.array([-0.11007, 0.0004, -0.00085])

OPENCV_4 = "%YAML:1.0\n---\n"
OPENCV_5 = "%YAML 1.2\n---\n"


def matrix(name, values):
    values = np.atleast_2d(values)
    data = ", ".join(f"{value:.17g}" for value in values.ravel())
    return (
        f"{name}: !!opencv-matrix\n   rows: {values.shape[0]}\n   cols: {values.shape[1]}\n"
        f"   dt: d\n   data: [ {data} ]\n"
    )


def vector_of_5(name, values):
    data = ", ".join(f"{value:.17g}" for value in values)
    return (
        f"{name}: !!opencv-nd-matrix\n   sizes: [ {len(values)} ]\n   dt: d\n   data: [ {data} ]\n"
    )


def opencv(header, names=("M1", "D1", "M2", "D2"), step=matrix):
    values = (K_LEFT, D_LEFT, K_RIGHT, D_RIGHT)
    cameras = "".join(matrix(name, value) for name, value in zip(names, values, strict=True))
    size = "image_width: 752\nimage_height: 480\n"
    return header + size + cameras + matrix("R", R) + step("T", T)


def kalibr():
    def camera(K, D):
        return (
            "  camera_model: pinhole\n  distortion_model: radtan\n"
            f"  distortion_coeffs: {list(D)}\n"
            f"  intrinsics: [{K[0, 0]}, {K[1, 1]}, {K[0, 2]}, {K[1, 2]}]\n"
            "  resolution: [752, 480]\n"
        )

    rows = np.vstack([np.column_stack([R, T]), [0, 0, 0, 1]]).tolist()
    step = "  T_cn_cnm1:\n" + "".join(f"  - {row}\n" for row in rows)
    return f"cam0:\n{camera(K_LEFT, D_LEFT)}cam1:\n{camera(K_RIGHT, D_RIGHT)}{step}"


@pytest.mark.parametrize(
    "text",
    [
        opencv(OPENCV_4),
        opencv(OPENCV_5),
        opencv(OPENCV_5, step=vector_of_5),
        opencv(OPENCV_4, ("K1", "D1", "K2", "D2")),
        opencv(OPENCV_5, ("cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2")),
        kalibr(),
    ],
    ids=["4.x", "5", "5 with a vector", "K1", "cameraMatrix1", "kalibr"],
)
@pytest.mark.parametrize("name", ["calib.txt", "rig.yaml"])
def test_every_yaml_format_gives_the_same_rig(tmp_path, text, name):
    path = tmp_path / name
    path.write_text(text)
    rig = read_calibration(path)
    np.testing.assert_allclose(rig.left.matrix, K_LEFT)
    np.testing.assert_allclose(rig.right.matrix, K_RIGHT)
    np.testing.assert_allclose(rig.left.distortion, D_LEFT)
    np.testing.assert_allclose(rig.right.distortion, D_RIGHT)
    np.testing.assert_allclose(rig.T_right_left[:3, :3], R, atol=1e-12)
    np.testing.assert_allclose(rig.T_right_left[:3, 3], T)
    assert rig.size == (752, 480)
    assert not rig.is_rectified


@pytest.mark.parametrize("text", [opencv(OPENCV_4), kalibr()], ids=["opencv", "kalibr"])
def test_residual_of_a_calibration_file_is_read(tmp_path, text):
    path = tmp_path / "calib.yaml"
    path.write_text(text)
    assert read_calibration(path).residual_px == TYPICAL_RESIDUAL_PX
    path.write_text(f"{text}residual_px: 0.05\n")
    assert read_calibration(path).residual_px == 0.05
    for wrong in ("-0.1", ".nan", "small"):
        path.write_text(f"{text}residual_px: {wrong}\n")
        with pytest.raises(InputError, match=r"calib.yaml: residual_px is .*, but a number >= 0"):
            read_calibration(path)


def test_file_written_by_opencv_is_read(tmp_path):
    import cv2

    path = tmp_path / "calib.yaml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, value in (("M1", K_LEFT), ("D1", np.array(D_LEFT)), ("M2", K_RIGHT),
                        ("D2", np.array([D_RIGHT])), ("R", R), ("T", T)):  # fmt: skip
        storage.write(name, value)
    storage.release()
    rig = read_calibration(path)
    np.testing.assert_array_equal(rig.left.distortion, D_LEFT)
    np.testing.assert_array_equal(rig.right.matrix, K_RIGHT)
    np.testing.assert_array_equal(rig.T_right_left[:3, 3], T)
    assert rig.size is None


def test_sensor_files_give_the_rig_and_its_pose_on_the_body(tmp_path):
    turn = np.array([[0, -1, 0, -0.02], [1, 0, 0, -0.06], [0, 0, 1, 0.01], [0, 0, 0, 1.0]])
    T_right_left = np.vstack([np.column_stack([R, T]), [0, 0, 0, 1]])
    for name, T_BS, K in (("l", turn, K_LEFT), ("r", turn @ np.linalg.inv(T_right_left), K_RIGHT)):
        data = ", ".join(f"{value:.15g}" for value in T_BS.ravel())
        (tmp_path / f"{name}.yaml").write_text(
            f"T_BS:\n  cols: 4\n  rows: 4\n  data: [{data}]\n"
            f"resolution: [752, 480]\nintrinsics: [{K[0, 0]}, {K[1, 1]}, {K[0, 2]}, {K[1, 2]}]\n"
            f"distortion_model: equidistant\ndistortion_coefficients: {D_LEFT}\n"
        )
    rig, T_body_left = read_sensors(tmp_path / "l.yaml", tmp_path / "r.yaml")
    np.testing.assert_allclose(T_body_left, turn, atol=1e-12)
    np.testing.assert_allclose(rig.T_right_left, T_right_left, atol=1e-12)
    assert rig.left.is_fisheye


def test_kitti_rows_need_no_label_and_no_final_newline(tmp_path):
    rows = [
        "707.1 0 601.9 0 0 707.1 183.1 0 0 0 1 0",
        "707.1 0 601.9 -379.8 0 707.1 183.1 0 0 0 1 0",
    ]
    for text in ("\n".join(rows), f"P0: {rows[0]}\nP1: {rows[1]}\nTr: 1 0 0 0\n"):
        (tmp_path / "calib.txt").write_text(text)
        rig = read_calibration(tmp_path / "calib.txt")
        assert rig.is_rectified
        assert rig.baseline == pytest.approx(379.8 / 707.1)


def test_middlebury_millimetres_become_metres(tmp_path):
    (tmp_path / "calib.txt").write_text(
        "cam0=[994.978 0 311.193; 0 994.978 254.877; 0 0 1]\n"
        "cam1=[994.978 0 342.279; 0 994.978 254.877; 0 0 1]\n"
        "doffs=31.086\nbaseline=193.001\nwidth=741\nheight=500\nndisp=70\n"
    )
    rig = read_calibration(tmp_path / "calib.txt")
    assert rig.is_rectified
    assert rig.baseline == pytest.approx(0.193001)
    assert rig.right.matrix[0, 2] - rig.left.matrix[0, 2] == pytest.approx(31.086)
    assert rig.size == (741, 500)
    assert rig.disparity_range == (0, 70)


@pytest.mark.parametrize("residual", ["0", "0.25", "-1", "much"])
def test_residual_of_a_middlebury_file_is_read(tmp_path, residual):
    path = tmp_path / "calib.txt"
    path.write_text(
        "cam0=[100 0 50; 0 100 40; 0 0 1]\ncam1=[100 0 50; 0 100 40; 0 0 1]\nbaseline=100\n"
        f"residual_px={residual}\n"
    )
    if residual in ("-1", "much"):
        with pytest.raises(InputError, match=r"calib.txt: residual_px is"):
            read_calibration(path)
    else:
        assert read_calibration(path).residual_px == float(residual)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 0 2 0 0 1 2 0 0 0 1 0\n", "holds 1 projection matrix, but two are needed"),
        ("P0: 1 0 2 0 0 1 2 0 0 0 1 0\nP1: 1 2\n", "P1 is ' 1 2', but 12 numbers are needed"),
        ("cam0=[1 0 1; 0 1 1; 0 0 1]\n", "cam1 is 'missing', but 9 numbers are needed"),
        (opencv(OPENCV_5).replace("M2:", "W2:"), "lacks K2 or M2"),
        (opencv(OPENCV_5).replace("T:", "t:"), "lacks T"),
        (opencv(OPENCV_5).replace("rows: 3", "rows: 4", 1), "not a calibration in YAML"),
        (kalibr().replace("radtan", "rational"), "camera model pinhole with rational is not known"),
        (kalibr().replace("pinhole", "omni"), "omni with .*: calibrate again as pinhole"),
        (kalibr().replace("cam1:", "cam7:"), "lacks cam1"),
        ("focal length: seven\n", "lacks K1 or M1"),
        ("P0: nan 0 40\nP1: 1 2 3\n", "'nan 0 40' is given, but numbers of shape"),
        ("just words", "holds no keys"),
        ("a: [1, 2\nb: 3", r"line 2: this is not a calibration in YAML"),
        (opencv(OPENCV_4).replace("458.654", "-458.654"), "focal lengths are -458.654"),
        ("M1: !!python/object/apply:os.system [ls]\n", "not a calibration in YAML"),
    ],
)  # fmt: skip
def test_invalid_value_is_named(tmp_path, text, message):
    (tmp_path / "calib.txt").write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        read_calibration(tmp_path / "calib.txt")
    assert "\n" not in str(caught.value)


def test_binary_files_are_rejected(tmp_path):
    (tmp_path / "calib.txt").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(InputError, match="is not UTF-8 text"):
        read_calibration(tmp_path / "calib.txt")
