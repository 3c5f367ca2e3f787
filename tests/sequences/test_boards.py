"""A rig comes out of images of a board as it was put in."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.sequences.calibration.boards import calibrate, write_calibration
from recon.sequences.calibration.files import read_calibration
from recon.sequences.listing import list_pairs

SIZE = (480, 360)
BOARD, SQUARE = (7, 5), 0.03
K = np.array([[420.0, 0, 236.0], [0, 421.0, 183.0], [0, 0, 1]])
TURN, STEP = np.array([0.01, -0.02, 0.005]), np.array([-0.12, 0.002, 0.001])


def board_image(rotation, step):
    """The board as a camera sees it whose frame the board stands in at `rotation`, `step`."""
    squares = np.indices((BOARD[1] + 1, BOARD[0] + 1)).sum(axis=0) % 2
    print_px = 40
    sheet = np.kron(squares, np.ones((print_px, print_px))) * 200 + 30
    sheet = np.pad(sheet, print_px, constant_values=230).astype(np.uint8)
    # Sheet pixel -> board metres, the first inner corner at the origin, then through the camera.
    scale = SQUARE / print_px
    to_board = np.array([[scale, 0, -1.9875 * SQUARE], [0, scale, -1.9875 * SQUARE], [0, 0, 1]])
    H = K @ np.column_stack([rotation[:, 0], rotation[:, 1], step]) @ to_board
    return cv2.warpPerspective(sheet, H, SIZE, flags=cv2.INTER_AREA, borderValue=120)


@pytest.fixture(scope="module")
def board_dirs(tmp_path_factory):
    path = tmp_path_factory.mktemp("boards")
    rng = np.random.default_rng(8)
    R_right_left = Rotation.from_rotvec(TURN).as_matrix()
    for side in ("left", "right"):
        (path / side).mkdir()
    for number in range(8):
        R = Rotation.from_rotvec(rng.uniform(-0.4, 0.4, 3)).as_matrix()
        step = np.array([-0.05, -0.05, 0.45]) + rng.uniform(-0.025, 0.025, 3)
        left = board_image(R, step)
        right = board_image(R_right_left @ R, R_right_left @ step + STEP)
        cv2.imwrite(str(path / "left" / f"left{number:02d}.png"), left)
        cv2.imwrite(str(path / "right" / f"right{number:02d}.png"), right)
    cv2.imwrite(str(path / "left" / "left08.png"), np.full(SIZE[::-1], 100, np.uint8))
    cv2.imwrite(str(path / "right" / "right08.png"), np.full(SIZE[::-1], 100, np.uint8))
    return path / "left", path / "right"


def test_the_rig_comes_out_and_is_read_back(board_dirs, tmp_path):
    found = calibrate(*board_dirs, BOARD, SQUARE)
    rig = found.calibration
    assert found.num_pairs == 8
    assert [skip.name for skip in found.skipped] == ["08"]
    assert "shows no whole board of 7 x 5" in found.skipped[0].reason
    assert 0.001 < found.rms_px < 0.1
    np.testing.assert_allclose(rig.left.matrix, K, atol=3)
    np.testing.assert_allclose(rig.T_right_left[:3, 3], STEP, atol=2e-3)
    assert rig.baseline == pytest.approx(np.linalg.norm(STEP), rel=0.005)
    write_calibration(found, tmp_path / "calib.yaml")
    read = read_calibration(tmp_path / "calib.yaml")
    np.testing.assert_array_equal(read.T_right_left, rig.T_right_left)
    np.testing.assert_array_equal(read.right.distortion, rig.right.distortion)
    assert read.size == SIZE
    assert (tmp_path / "calib.yaml").read_text().startswith("%YAML")


def test_the_unit_is_that_of_the_square(board_dirs):
    metres, millimetres = (calibrate(*board_dirs, BOARD, side) for side in (SQUARE, 1000 * SQUARE))
    ratio = millimetres.calibration.baseline / metres.calibration.baseline
    assert ratio == pytest.approx(1000, rel=1e-3)


def test_another_board_is_not_found(board_dirs):
    with pytest.raises(InputError, match=r"0 pairs show a whole board of 9 x 6 .* first fault"):
        calibrate(*board_dirs, (9, 6), SQUARE)


@pytest.mark.data
def test_opencvs_boards_give_a_quarter_of_a_pixel(data_dir, tmp_path):
    for side in ("left", "right"):
        (tmp_path / side).mkdir()
        for file in (data_dir / "chessboard_stereo" / "opencv").glob(f"{side}*.jpg"):
            (tmp_path / side / file.name).symlink_to(file)
    found = calibrate(tmp_path / "left", tmp_path / "right", (9, 6), 0.025)
    assert found.num_pairs == 13
    assert 0.1 < found.rms_px < 0.25
    assert found.calibration.baseline == pytest.approx(3.33 * 0.025, rel=0.01)


def test_one_folder_may_hold_both_sides_but_never_mixes_them(tmp_path):
    for side in ("left", "right"):
        for number in (1, 2):
            cv2.imwrite(str(tmp_path / f"{side}{number:02d}.png"), np.zeros((9, 9), np.uint8))
    listed = list_pairs(tmp_path, tmp_path)
    assert [(pair.left.name, pair.right.name) for pair in listed] == [
        ("left01.png", "right01.png"),
        ("left02.png", "right02.png"),
    ]
    for path in tmp_path.glob("right*"):
        path.unlink()
    with pytest.raises(InputError, match="no name in it says right"):
        list_pairs(tmp_path, tmp_path)
