"""A rig is recovered from images of a board."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recon.errors import InputError, ReconError
from recon.notices import collected_notices
from recon.sequences.calibration.boards import calibrate, write_calibration
from recon.sequences.calibration.files import read_calibration
from recon.sequences.calibration.targets import Charuco, Chessboard, parse_target
from recon.sequences.listing import list_pairs
from recon.sequences.rectified_images import rectify_files
from tests.sequences.drawn_boards import (
    BOARD,
    SIZE,
    SQUARE,
    STEP,
    TURN,
    K,
    draw_boards,
)
from tests.sequences.recordings import middlebury_keys


def chessboard(corners=BOARD, square=SQUARE):
    return Chessboard(columns=corners[0], rows=corners[1], square=square)


@pytest.fixture(scope="module")
def board_dirs(tmp_path_factory):
    path = draw_boards(tmp_path_factory.mktemp("boards"))
    for side in ("left", "right"):
        cv2.imwrite(str(path / side / f"{side}08.png"), np.full(SIZE[::-1], 100, np.uint8))
    return path / "left", path / "right"


def test_rig_is_recovered_and_read_back(board_dirs, tmp_path):
    found = calibrate(*board_dirs, chessboard())
    rig = found.calibration
    assert found.num_pairs == 8
    assert [skip.name for skip in found.skipped] == ["08"]
    assert "shows no whole board of 7 x 5" in found.skipped[0].reason
    assert 0.001 < found.rms_px < 0.1
    np.testing.assert_allclose(rig.left.matrix, K, atol=3)
    np.testing.assert_allclose(rig.T_right_left[:3, 3], STEP, atol=2e-3)
    assert rig.baseline == pytest.approx(np.linalg.norm(STEP), rel=0.005)
    write_calibration(rig, tmp_path / "calib.yaml")
    read = read_calibration(tmp_path / "calib.yaml")
    np.testing.assert_array_equal(read.T_right_left, rig.T_right_left)
    np.testing.assert_array_equal(read.right.distortion, rig.right.distortion)
    assert read.size == SIZE
    assert (tmp_path / "calib.yaml").read_text().startswith("%YAML")


def test_unit_is_that_of_the_square_size(board_dirs):
    metres, millimetres = (
        calibrate(*board_dirs, chessboard(square=side)) for side in (SQUARE, 1000 * SQUARE)
    )
    ratio = millimetres.calibration.baseline / metres.calibration.baseline
    assert ratio == pytest.approx(1000, rel=1e-3)


def test_swapped_folders_are_reported(board_dirs):
    with collected_notices() as notices:
        found = calibrate(*board_dirs, chessboard())
        assert notices == []
        swapped = calibrate(*board_dirs[::-1], chessboard())
    assert [notice.code for notice in notices] == ["left-right-swapped"]
    assert swapped.calibration.baseline == pytest.approx(found.calibration.baseline, rel=1e-3)


def test_board_of_other_dimensions_is_not_found(board_dirs):
    with pytest.raises(InputError, match=r"0 pairs show a whole board of 9 x 6 .* first error"):
        calibrate(*board_dirs, chessboard((9, 6)))


@pytest.mark.data
def test_opencv_sample_boards_give_a_quarter_of_a_pixel(data_dir, tmp_path):
    for side in ("left", "right"):
        (tmp_path / side).mkdir()
        for file in (data_dir / "chessboard_stereo" / "opencv").glob(f"{side}*.jpg"):
            (tmp_path / side / file.name).symlink_to(file)
    found = calibrate(tmp_path / "left", tmp_path / "right", chessboard((9, 6), 0.025))
    assert found.num_pairs == 13
    assert 0.1 < found.rms_px < 0.25
    assert found.calibration.baseline == pytest.approx(3.33 * 0.025, rel=0.01)
    assert found.dropped == ()
    names = ("right04.jpg", "right08.jpg")
    for name, other in zip(names, reversed(names), strict=True):
        file = tmp_path / "right" / name
        file.unlink()
        file.symlink_to(data_dir / "chessboard_stereo" / "opencv" / other)
    with collected_notices() as notices:
        again = calibrate(tmp_path / "left", tmp_path / "right", chessboard((9, 6), 0.025))
    assert again.dropped == ("04", "08")
    assert again.num_pairs == 11
    assert again.rms_px < 0.25
    assert [notice.code for notice in notices] == ["calibration-pairs-dropped"]


def test_one_folder_may_hold_both_sides_without_mixing_them(tmp_path):
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
    with pytest.raises(InputError, match="no name in it contains right"):
        list_pairs(tmp_path, tmp_path)


def test_boards_detected_rotated_in_one_camera_are_resolved(monkeypatch, board_dirs):
    """The detector is patched to rotate every third board, in one camera only."""
    target = chessboard()
    calls = iter(range(1000))
    plain = Chessboard.find

    def sometimes_rotated(self, image):
        corners, call = plain(self, image), next(calls)
        if corners is None or call % 6 != 1:
            return corners
        points = corners.points_px[self.orders[1]]
        return type(corners)(numbers=corners.numbers, points_px=points)

    monkeypatch.setattr(Chessboard, "find", sometimes_rotated)
    found = calibrate(*board_dirs, target)
    assert found.num_pairs == 8
    assert found.rms_px < 0.1
    assert found.calibration.baseline == pytest.approx(np.linalg.norm(STEP), rel=0.005)


def test_corner_orders_of_a_board_are_its_rotations():
    assert [len(set(order)) for order in chessboard((3, 2)).orders] == [6, 6]
    np.testing.assert_array_equal(chessboard((3, 2)).orders[1], [5, 4, 3, 2, 1, 0])
    assert len(chessboard((4, 4)).orders) == 4


def test_poor_calibration_is_rejected_unless_forced(monkeypatch, board_dirs):
    plain, rng = Chessboard.find, np.random.default_rng(1)

    def shaken(self, image):
        corners = plain(self, image)
        if corners is None:
            return None
        noise = rng.normal(0, 3, corners.points_px.shape).astype(np.float32)
        return type(corners)(numbers=corners.numbers, points_px=corners.points_px + noise)

    monkeypatch.setattr(Chessboard, "find", shaken)
    with pytest.raises(ReconError, match=r"is off by \d.* px .*--force"):
        calibrate(*board_dirs, chessboard())
    assert calibrate(*board_dirs, chessboard(), force=True).rms_px > 1


CHARUCO = Charuco(columns=7, rows=5, square=SQUARE, marker=0.75 * SQUARE, dictionary="DICT_4X4_50")


def charuco_images(path, num_pairs=8):
    """Boards that are partly outside the images."""
    rng, side = np.random.default_rng(3), 40
    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard((7, 5), SQUARE, 0.75 * SQUARE, words)
    sheet = board.generateImage((7 * side, 5 * side))
    to_board = np.array([[SQUARE / side, 0, 0], [0, SQUARE / side, 0], [0, 0, 1]])
    R_right_left = Rotation.from_rotvec(TURN).as_matrix()
    for folder in ("left", "right"):
        (path / folder).mkdir(parents=True)
    for number in range(num_pairs):
        R = Rotation.from_rotvec(rng.uniform(-0.4, 0.4, 3)).as_matrix()
        step = np.array([-0.02, -0.09, 0.33]) + rng.uniform(-0.04, 0.04, 3)
        places = {"left": (R, step), "right": (R_right_left @ R, R_right_left @ step + STEP)}
        for folder, (rotation, t) in places.items():
            H = K @ np.column_stack([rotation[:, 0], rotation[:, 1], t]) @ to_board
            image = cv2.warpPerspective(sheet, H, SIZE, flags=cv2.INTER_AREA, borderValue=120)
            cv2.imwrite(str(path / folder / f"{number:02d}.png"), image)
    return path / "left", path / "right"


@pytest.mark.parametrize("dictionary", ["DICT_4X4_50", None])
def test_charuco_board_may_be_partly_visible(tmp_path, dictionary):
    left, right = charuco_images(tmp_path)
    target = parse_target("charuco:7x5" + (f":{dictionary}" if dictionary else ""), SQUARE)
    assert target.marker == CHARUCO.marker
    found = calibrate(left, right, target)
    assert found.num_pairs >= 6
    assert found.rms_px < 0.3
    assert found.calibration.baseline == pytest.approx(np.linalg.norm(STEP), rel=0.02)


@pytest.mark.parametrize(
    "text", ["9", "9x", "1x6", "charuco:9", "charuco:5x5:DICT_9", "other:5x5", "9x6x3", "999x999"]
)
def test_invalid_boards_are_rejected(text):
    with pytest.raises(InputError, match=r"is needed|are needed"):
        parse_target(text, SQUARE)


def test_rectified_images_need_no_further_rectification(board_dirs, tmp_path):
    rig = calibrate(*board_dirs, chessboard()).calibration
    write_calibration(rig, tmp_path / "calib.yaml")
    done = rectify_files(*board_dirs, tmp_path / "calib.yaml", tmp_path / "out")
    assert done.num_pairs == 9
    again = read_calibration(tmp_path / "out")
    assert again.is_rectified
    assert again.baseline == pytest.approx(rig.baseline, rel=1e-9)
    corners = [
        chessboard().find(cv2.imread(str(tmp_path / "out" / side / "00.png"), 0)).points_px
        for side in ("left", "right")
    ]
    rows_apart = corners[0][:, 1] - corners[1][:, 1]
    assert np.abs(rows_apart).max() < 0.3
    one = rectify_files(
        board_dirs[0] / "left00.png", board_dirs[1] / "right00.png", tmp_path / "calib.yaml",
        tmp_path / "one",
    )  # fmt: skip
    assert one.num_pairs == 1
    assert {file.name for file in (tmp_path / "one").iterdir()} == {
        "left.png", "right.png", "calib.txt",
    }  # fmt: skip


def test_images_of_different_sizes_leave_no_folder(tmp_path):
    for side, width in (("left", 96), ("right", 90)):
        cv2.imwrite(str(tmp_path / f"{side}.png"), np.zeros((64, width), np.uint8))
    (tmp_path / "calib.txt").write_text(middlebury_keys())
    images = (tmp_path / "left.png", tmp_path / "right.png")
    with pytest.raises(InputError, match=r"right\.png: the right image has 90 x 64 pixels"):
        rectify_files(*images, tmp_path / "calib.txt", tmp_path / "out")
    assert not (tmp_path / "out").exists()
