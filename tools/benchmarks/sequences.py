"""Recorded data: drift, confirmation, rectification, calibration, temple; empty without data."""

import json
import os
import tempfile
import time
from itertools import islice
from pathlib import Path
from statistics import median

import cv2
import numpy as np

from benchmarks import Measurement
from recon.mapping.consistency import Consistency, Witness
from recon.mapping.pair import match_points
from recon.records import PairSource, StereoPair
from recon.sequences import open_sequence
from recon.sequences.calibration.boards import calibrate
from recon.sequences.calibration.cameras import Calibration, Camera
from recon.sequences.calibration.rectification import rectifier
from recon.sequences.calibration.targets import Chessboard
from recon.sequences.images import read_image
from recon.settings import SequenceSettings, Settings, updated, with_quality

DATA = Path(os.environ.get("RECON_DATA", Path(__file__).parents[3] / "shared" / "data"))
DRIVE = DATA / "kitti_odometry" / "sequence_1"
TEMPLE = DATA / "middlebury_mvs" / "templeSparseRing"
TEMPLE_BOX = np.array([[-0.073568, 0.021728, -0.012445], [0.028855, 0.181892, 0.062736]])
"""Of its README, metres."""
BOX_MARGIN = 0.003
NUM_DISPARITIES = 128


def measure(quick: bool) -> list[Measurement]:
    """Run all measurements of the topic; `quick` uses only the start of the drive."""
    if not DRIVE.is_dir():
        return []
    cv2.setNumThreads(1)
    num_pairs = 12 if quick else None
    return [
        *odometry(num_pairs),
        *confirmation(num_pairs),
        *boards(),
        *rectification(),
        *temple(),
    ]


def odometry(num_pairs: int | None) -> list[Measurement]:
    """Measure drift from the given poses, and the cost of a frame relative to StereoSGBM."""
    source = open_sequence(DRIVE, SequenceSettings(poses="estimated"))
    began = time.thread_time()
    pairs = [*islice(source, num_pairs)]
    a_frame = (time.thread_time() - began) / len(pairs)
    true = [
        pair.T_world_left for pair in islice(open_sequence(DRIVE, SequenceSettings()), num_pairs)
    ]
    positions = np.array(true)[:, :3, 3]
    length = np.linalg.norm(np.diff(positions, axis=0), axis=1).sum()
    end = np.linalg.norm(pairs[-1].T_world_left[:3, 3] - positions[-1])
    return [
        number("odometry_drift", source.metrics["drift_percent"], "percent", 0.5),
        number("odometry_end", 100 * end / length, "percent", 0.3),
        number("odometry_ratio", a_frame / sgbm_seconds(pairs), "of StereoSGBM's time", 0.3),
    ]


def confirmation(num_pairs: int | None) -> list[Measurement]:
    """Measure the share of points within 30 m confirmed by a neighbouring pair, and the time."""
    search = {"matching": {"min_disparity": 0, "max_disparity": NUM_DISPARITIES - 1}}
    settings = updated(Settings(), search)
    fast = updated(with_quality(Settings(), "fast"), search)
    pairs = [*islice(open_sequence(DRIVE, SequenceSettings()), num_pairs)]
    match_points(pairs[0], settings)  # compiles the kernels
    consistency, times = run_through(pairs, settings)
    _, fast_times = run_through(pairs[:6], fast)
    peer = sgbm_seconds(pairs)
    return [
        number("confirmed_share", 100 * consistency.share, "percent", 0.03, better="higher"),
        number("best_frame_ratio", median(times) / peer, "of StereoSGBM's time", 0.3),
        number("fast_frame_ratio", median(fast_times) / peer, "of StereoSGBM's time", 0.3),
    ]


def run_through(source: PairSource, settings: Settings) -> tuple[Consistency, list[float]]:
    """Compare the points of all pairs with each other; return CPU seconds per pair."""
    consistency, times = Consistency(), []
    for pair in source:
        began = time.thread_time()
        consistency.add(pair, match_points(pair, settings).cloud)
        times.append(time.thread_time() - began)
    consistency.finish()
    return consistency, times


def sgbm_seconds(pairs: list[StereoPair]) -> float:
    """Median CPU seconds of StereoSGBM on a pair."""
    peer = cv2.StereoSGBM.create(0, NUM_DISPARITIES, 5, 200, 800)
    times = []
    for pair in pairs[:5]:
        began = time.thread_time()
        peer.compute(pair.left, pair.right)
        times.append(time.thread_time() - began)
    return median(times)


def boards() -> list[Measurement]:
    """Reprojection error of OpenCV's chessboards."""
    with tempfile.TemporaryDirectory() as folder:
        sides = [Path(folder) / side for side in ("left", "right")]
        for side in sides:
            side.mkdir()
            for file in (DATA / "chessboard_stereo" / "opencv").glob(f"{side.name}*.jpg"):
                (side / file.name).symlink_to(file)
        found = calibrate(sides[0], sides[1], Chessboard(columns=9, rows=6, square=0.025))
    return [number("chessboard_rms", found.rms_px, "px", 0.05)]


def rectification() -> list[Measurement]:
    """Median row error of matches on EuRoC's rectified pairs."""
    folder = DATA / "euroc" / "v1_four_frames"
    rig = json.loads((folder / "meta.json").read_text())["calibration"]
    cameras = [
        Camera(matrix=np.array(rig[name]["K"]), distortion=np.array(rig[name]["dist"]))
        for name in ("cam0", "cam1")
    ]
    calibration = Calibration(
        left=cameras[0], right=cameras[1], T_right_left=np.array(rig["T_cam1_cam0"])
    )
    rectify = rectifier(calibration, tuple(rig["resolution"]))
    errors = [
        row_errors(*rectify(*(read_image(folder / side / file.name) for side in ("left", "right"))))
        for file in sorted((folder / "left").iterdir())
    ]
    return [number("euroc_row_error", float(np.median(np.concatenate(errors))), "px", 0.1)]


def row_errors(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """|v_right - v_left| of matched SIFT features, without mismatches of 5 px and more."""
    sift = cv2.SIFT_create()
    (points, a), (others, b) = (sift.detectAndCompute(image, None) for image in (left, right))
    both = cv2.BFMatcher().knnMatch(a, b, k=2)
    good = [first for first, second in both if first.distance < 0.75 * second.distance]
    offset = np.array([others[m.trainIdx].pt[1] - points[m.queryIdx].pt[1] for m in good])
    return np.abs(offset[np.abs(offset) < 5])


def temple() -> list[Measurement]:
    """Measure the share of points in the temple's box, and their distance to other pairs."""
    source = open_sequence(TEMPLE, SequenceSettings())
    search = {"matching": {"min_disparity": 0, "max_disparity": source.disparity_range[1]}}
    settings, consistency = updated(Settings(), search), Consistency()
    witnesses: list[Witness] = []
    for pair in source:
        witnesses += consistency.add(pair, match_points(pair, settings).cloud)
    witnesses += consistency.finish()
    points = np.concatenate([w.cloud.points for w in witnesses])
    agreed = np.concatenate([w.cloud.points[w.is_confirmed] for w in witnesses])
    distances = np.concatenate([w.distance[w.is_confirmed[w.sample]] for w in witnesses])
    return [
        number("temple_in_box", 100 * in_box(points), "percent", 0.03, better="higher"),
        number("temple_agreed_in_box", 100 * in_box(agreed), "percent", 0.02, better="higher"),
        number("temple_agreed_distance", 1e3 * float(np.median(distances)), "mm", 0.1),
    ]


def in_box(points: np.ndarray) -> float:
    """Share of points (N, 3) in the temple's box."""
    low, high = TEMPLE_BOX
    return float(((points > low - BOX_MARGIN) & (points < high + BOX_MARGIN)).all(axis=1).mean())


def number(
    name: str, value: float, unit: str, tolerance: float, *, better: str = "lower"
) -> Measurement:
    """Make a measurement of this topic."""
    return Measurement(
        name=f"sequences.{name}", value=value, unit=unit, better=better, tolerance=tolerance
    )
