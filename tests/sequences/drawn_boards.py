"""Images of a chessboard in the two cameras of a known rig."""

from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

SIZE = (480, 360)
BOARD, SQUARE = (7, 5), 0.03
K = np.array([[420.0, 0, 236.0], [0, 421.0, 183.0], [0, 0, 1]])
TURN, STEP = np.array([0.01, -0.02, 0.005]), np.array([-0.12, 0.002, 0.001])


def board_image(rotation, step, board=BOARD, square=SQUARE):
    """Render the board in a camera, at `rotation` and `step` in the camera's frame."""
    squares = np.indices((board[1] + 1, board[0] + 1)).sum(axis=0) % 2
    print_px = 40
    sheet = np.kron(squares, np.ones((print_px, print_px))) * 200 + 30
    sheet = np.pad(sheet, print_px, constant_values=230).astype(np.uint8)
    # Sheet pixel -> board metres, the first inner corner at the origin, then through the camera.
    scale = square / print_px
    to_board = np.array([[scale, 0, -1.9875 * square], [0, scale, -1.9875 * square], [0, 0, 1]])
    H = K @ np.column_stack([rotation[:, 0], rotation[:, 1], step]) @ to_board
    return cv2.warpPerspective(sheet, H, SIZE, flags=cv2.INTER_AREA, borderValue=120)


def draw_boards(path: Path, board=BOARD, square=SQUARE) -> Path:
    """Write eight pairs of a board in all orientations to `left` and `right` of a folder."""
    rng = np.random.default_rng(8)
    R_right_left = Rotation.from_rotvec(TURN).as_matrix()
    for side in ("left", "right"):
        (path / side).mkdir(parents=True)
    for number in range(8):
        R = Rotation.from_rotvec(rng.uniform(-0.4, 0.4, 3)).as_matrix()
        step = np.array([-0.05, -0.05, 0.45]) + rng.uniform(-0.025, 0.025, 3)
        left = board_image(R, step, board, square)
        right = board_image(R_right_left @ R, R_right_left @ step + STEP, board, square)
        cv2.imwrite(str(path / "left" / f"left{number:02d}.png"), left)
        cv2.imwrite(str(path / "right" / f"right{number:02d}.png"), right)
    return path
