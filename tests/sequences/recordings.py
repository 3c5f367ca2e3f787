"""Small recordings in every format, all of the same four pairs, for the tests of the readers."""

import json
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.camera import StereoRig
from recon.geometry import pose

NUM_PAIRS = 4
DISPARITY_PX = 6
RIG = StereoRig(
    width=96, height=64, focal_px=80.0, cx_left_px=47.0, cx_right_px=47.0, cy_px=31.0, baseline=0.5
)


def image_pairs():
    """Make grey (left, right) pairs; the right image is the left one shifted by the disparity."""
    rng = np.random.default_rng(7)
    for _ in range(NUM_PAIRS):
        wide = rng.integers(0, 256, (RIG.height, RIG.width + DISPARITY_PX), np.uint8)
        yield wide[:, :-DISPARITY_PX].copy(), wide[:, DISPARITY_PX:].copy()


def poses_recorded():
    """Give `T_recorded_left` of a rig that drives forward, in KITTI's convention."""
    return [pose(np.eye(3), [0.0, 0.0, 0.7 * number]) for number in range(NUM_PAIRS)]


def random_poses() -> NDArray[np.float64]:
    """Give `NUM_PAIRS` poses with any rotation, the same at every call."""
    rng = np.random.default_rng(5)
    turns = Rotation.random(NUM_PAIRS, rng=rng).as_matrix()
    places = rng.normal(size=(NUM_PAIRS, 3))
    return np.stack([pose(R, t) for R, t in zip(turns, places, strict=True)])


def kitti_rows(*, labels: bool = False) -> str:
    K = f"{RIG.focal_px} 0 {RIG.cx_left_px} {{}} 0 {RIG.focal_px} {RIG.cy_px} 0 0 0 1 0"
    rows = [K.format(0), K.format(-RIG.focal_px * RIG.baseline)]
    names = ("P0: ", "P1: ") if labels else ("", "")
    return "\n".join(name + row for name, row in zip(names, rows, strict=True))


def middlebury_keys() -> str:
    K = f"[{RIG.focal_px} 0 {RIG.cx_left_px}; 0 {RIG.focal_px} {RIG.cy_px}; 0 0 1]"
    return (
        f"cam0={K}\ncam1={K}\ndoffs=0\nbaseline={1000 * RIG.baseline}\n"
        f"width={RIG.width}\nheight={RIG.height}\nndisp=16\n"
    )


def kitti_poses() -> str:
    rows = (T[:3].ravel() for T in poses_recorded())
    return "\n".join(" ".join(f"{value:.9e}" for value in row) for row in rows)


def write_images(left_dir: Path, right_dir: Path) -> None:
    for folder in (left_dir, right_dir):
        folder.mkdir(parents=True)
    for number, (left, right) in enumerate(image_pairs()):
        cv2.imwrite(str(left_dir / f"{number:06d}.png"), left)
        cv2.imwrite(str(right_dir / f"{number:06d}.png"), right)


def write_folder(path: Path) -> Path:
    write_images(path / "left", path / "right")
    (path / "calib.txt").write_text(kitti_rows())
    (path / "poses.txt").write_text(kitti_poses())
    return path


def write_kitti(path: Path) -> Path:
    write_images(path / "image_0", path / "image_1")
    (path / "calib.txt").write_text(kitti_rows(labels=True))
    (path / "poses.txt").write_text(kitti_poses())
    (path / "times.txt").write_text("\n".join(str(float(n)) for n in range(NUM_PAIRS)))
    return path


def write_euroc(path: Path) -> Path:
    """Write frames one second apart; the body is rotated against the camera, as in EuRoC."""
    T_body_left = np.array([[0, -1, 0, 0.1], [1, 0, 0, 0], [0, 0, 1, 0.2], [0, 0, 0, 1.0]])
    T_left_right = RIG.T_left_right
    write_images(path / "mav0/cam0/data", path / "mav0/cam1/data")
    for camera, T_body_camera in (("cam0", T_body_left), ("cam1", T_body_left @ T_left_right)):
        folder = path / "mav0" / camera
        (folder / "sensor.yaml").write_text(_sensor(T_body_camera))
        names = [f"{n}000000000,{n:06d}.png" for n in range(NUM_PAIRS)]
        (folder / "data.csv").write_text("#timestamp [ns],filename\n" + "\n".join(names))
    truth = path / "mav0/state_groundtruth_estimate0"
    truth.mkdir()
    rows = ["#timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z"]
    for number, T_recorded_left in enumerate(poses_recorded()):
        T = T_recorded_left @ np.linalg.inv(T_body_left)
        # The body is rotated by a quarter turn about z.
        values = [*T[:3, 3], np.sqrt(0.5), 0.0, 0.0, -np.sqrt(0.5)]
        rows.append(f"{number}000000000," + ",".join(f"{value:.12f}" for value in values))
    (truth / "data.csv").write_text("\n".join(rows))
    return path


def _sensor(T_body_camera: np.ndarray) -> str:
    data = ", ".join(str(value) for value in T_body_camera.ravel())
    return (
        f"sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [{data}]\n"
        f"resolution: [{RIG.width}, {RIG.height}]\ncamera_model: pinhole\n"
        f"intrinsics: [{RIG.focal_px}, {RIG.focal_px}, {RIG.cx_left_px}, {RIG.cy_px}]\n"
        "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n"
    )


def write_pair_dir(path: Path, number: int = 0) -> Path:
    path.mkdir(parents=True)
    left, right = [*image_pairs()][number]
    cv2.imwrite(str(path / "left.png"), left)
    cv2.imwrite(str(path / "right.png"), right)
    truth = np.full(left.shape, 8 * DISPARITY_PX, np.uint8)
    truth[:, :DISPARITY_PX] = 0
    cv2.imwrite(str(path / "disp_left.png"), truth)
    (path / "meta.json").write_text(json.dumps({"truth_scale": 8}))
    (path / "calib.txt").write_text(middlebury_keys())
    return path


def write_simulated(path: Path) -> Path:
    for number in range(NUM_PAIRS):
        write_pair_dir(path / f"{number:06d}", number)
    (path / "poses.txt").write_text(kitti_poses())
    return path


def write_video(path: Path) -> Path:
    """Write Motion JPEG at full quality, which keeps the images almost unchanged."""
    path.mkdir()
    for side, name in enumerate(("left.avi", "right.avi")):
        video = cv2.VideoWriter(
            str(path / name), cv2.VideoWriter_fourcc(*"FFV1"), 1.0, (RIG.width, RIG.height)
        )
        for pair in image_pairs():
            video.write(cv2.cvtColor(pair[side], cv2.COLOR_GRAY2BGR))
        video.release()
    (path / "calib.txt").write_text(kitti_rows())
    (path / "poses.txt").write_text(kitti_poses())
    return path


def write_ros1(path: Path) -> Path:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    path.mkdir()
    with Writer(path / "drive.bag") as writer:
        store = get_typestore(Stores.ROS1_NOETIC)
        _write_messages(writer, store, store.serialize_ros1, {"seq": 0})
    _write_beside_bag(path)
    return path / "drive.bag"


def write_ros2(path: Path) -> Path:
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    path.mkdir()
    with Writer(path / "drive", version=9) as writer:
        store = get_typestore(Stores.ROS2_HUMBLE)
        _write_messages(writer, store, store.serialize_cdr, {})
    _write_beside_bag(path)
    return path / "drive"


def _write_beside_bag(path: Path) -> None:
    poses = [f"{n} 0 0 {0.7 * n} 0 0 0 1" for n in range(NUM_PAIRS)]
    (path / "poses.txt").write_text("\n".join(poses))


def _write_messages(writer, store, serialise, extra_header) -> None:
    Header, Time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    Image, Info = store.types["sensor_msgs/msg/Image"], store.types["sensor_msgs/msg/CameraInfo"]
    Region = store.types["sensor_msgs/msg/RegionOfInterest"]

    def add(topic, message):
        kind = message.__msgtype__
        if topic not in connections:
            connections[topic] = writer.add_connection(topic, kind, typestore=store)
        writer.write(connections[topic], number * 10**9, serialise(message, kind))

    connections = {}
    for number, pair in enumerate(image_pairs()):
        for side, image in zip(("left", "right"), pair, strict=True):
            header = Header(stamp=Time(sec=number, nanosec=0), frame_id=side, **extra_header)
            add(f"/stereo/{side}/image_rect", Image(
                header=header, height=RIG.height, width=RIG.width, encoding="mono8",
                is_bigendian=0, step=RIG.width, data=image.ravel(),
            ))  # fmt: skip
            step = -RIG.focal_px * RIG.baseline if side == "right" else 0.0
            P = np.array([RIG.focal_px, 0, RIG.cx_left_px, step, 0, RIG.focal_px, RIG.cy_px, 0,
                          0, 0, 1, 0.0])  # fmt: skip
            K = P.reshape(3, 4)[:, :3].ravel().copy()
            matrices = {"D": np.zeros(5), "K": K, "R": np.eye(3).ravel(), "P": P}
            if not extra_header:
                matrices = {name.lower(): value for name, value in matrices.items()}
            add(f"/stereo/{side}/camera_info", Info(
                header=header, height=RIG.height, width=RIG.width, distortion_model="plumb_bob",
                binning_x=0, binning_y=0, roi=Region(0, 0, 0, 0, False), **matrices,
            ))  # fmt: skip
