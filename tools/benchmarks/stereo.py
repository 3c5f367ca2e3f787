"""From pairs to refined matches, relative to OpenCV's StereoSGBM: alternating, CPU time."""

import time
from pathlib import Path
from statistics import median

import cv2
import numpy as np

from benchmarks import Measurement, cpu_seconds
from recon.libraries import limit_threads
from recon.records import Matches
from recon.settings import Quality, Settings, updated, with_quality
from recon.stereo.evaluation import coverage, evaluate
from recon.stereo.features import detect
from recon.stereo.matching.matching import match
from recon.stereo.subpixel import refine

PAIR = Path(__file__).parents[2] / "data" / "motorcycle"
SIZES = {(256, 256): 32, (384, 288): 32, (741, 500): 80}
"""Width and height, and how many disparities are searched."""
GROWTH = (256, 512, 1024, 2048)
"""Sides of the square images that show how time grows."""
NUM_KEPT = 5742
"""Number of the pair's matches that are judged."""
QUALITIES: tuple[Quality, ...] = ("fast", "best")

Images = tuple[np.ndarray, np.ndarray]


def measure(quick: bool) -> list[Measurement]:
    """Measure time ratios, stage times, growth with image size, and accuracy."""
    limit_threads(1)
    repeats = 3 if quick else 15
    found = []
    for quality in QUALITIES:
        for size, num_disparities in SIZES.items():
            found += speed(quality, size, num_disparities, repeats)
        found += accuracy(quality)
    for quality in QUALITIES:
        found += growth(quality, GROWTH[:2] if quick else GROWTH)
    return found


def images(size: tuple[int, int]) -> Images:
    """Load the golden pair at a size."""
    paths = sorted(PAIR.glob("left.*")) + sorted(PAIR.glob("right.*"))
    left, right = (cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in paths)
    area = cv2.INTER_AREA
    return cv2.resize(left, size, interpolation=area), cv2.resize(right, size, interpolation=area)


def settings(quality: Quality, num_disparities: int) -> Settings:
    """Make the settings of a quality for a search range that starts at 0."""
    search = {"matching": {"min_disparity": 0, "max_disparity": num_disparities - 1}}
    return updated(with_quality(Settings(), quality), search)


def run(pair: Images, s: Settings) -> tuple[Matches, list[float]]:
    """Match a pair; also the CPU seconds of features, matching and sub-pixel refinement."""
    clock = [time.thread_time()]
    left, right = (detect(image, s.features) for image in pair)
    clock.append(time.thread_time())
    matches = match(left, right, s.matching)
    clock.append(time.thread_time())
    matches = refine(matches, left, right)
    clock.append(time.thread_time())
    return matches, [float(step) for step in np.diff(clock)]


def speed(
    quality: Quality, size: tuple[int, int], num_disparities: int, repeats: int
) -> list[Measurement]:
    """Measure medians of runs that alternate with StereoSGBM."""
    pair, s = images(size), settings(quality, num_disparities)
    peer = cv2.StereoSGBM.create(0, num_disparities, 3, 72, 288)
    run(pair, s)  # compiles the kernels
    peers, stages = [], []
    for _ in range(repeats):
        peers.append(cpu_seconds(lambda: peer.compute(*pair)))
        stages.append(run(pair, s)[1])
    name = f"stereo.{quality}_{size[0]}x{size[1]}"
    ratio = median(map(sum, stages)) / median(peers)
    found = [number(f"{name}_ratio", ratio, "of StereoSGBM's time", 0.25)]
    for stage, times in zip(("features", "matching", "tuning"), np.transpose(stages), strict=True):
        found.append(number(f"{name}_{stage}", 1e3 * float(np.median(times)), "ms", 1.0))
    return found


def growth(quality: Quality, sides: tuple[int, ...]) -> list[Measurement]:
    """Measure the time per pixel in square images; 1 if time is linear in the number of pixels.

    Takes the shortest of alternating runs, as slow phases of the machine would look like growth.
    """
    s = settings(quality, 64)
    pairs = {side: images((side, side)) for side in sides}
    rounds = [{side: sum(run(pair, s)[1]) for side, pair in pairs.items()} for _ in range(6)]
    each = {side: min(times[side] for times in rounds) / side**2 for side in sides}
    unit = f"of a pixel's time at {sides[0]}"
    return [
        number(f"stereo.{quality}_{side}x{side}_growth", each[side] / each[sides[0]], unit, 0.3)
        for side in sides[1:]
    ]


def accuracy(quality: Quality) -> list[Measurement]:
    """Measure the accuracy of the most confident matches of the whole pair."""
    (truth_path,) = PAIR.glob("disp_left.*")
    truth = cv2.imread(str(truth_path), cv2.IMREAD_UNCHANGED).astype(np.float64)
    truth[~np.isfinite(truth) | (truth == 0)] = np.nan
    pair = images(truth.shape[::-1])
    matches = run(pair, settings(quality, 64))[0].select(slice(0, NUM_KEPT))
    judged = evaluate(matches, truth)
    name = f"stereo.{quality}_motorcycle"
    return [
        number(f"{name}_success", judged.success_all, "percent", 0.005, "higher"),
        number(f"{name}_subpixel_median", judged.subpixel_median_px, "px", 0.1),
        number(f"{name}_subpixel_rms", judged.subpixel_rms_px, "px", 0.1),
        number(
            f"{name}_coverage", coverage(matches, truth.shape), "of 32 px blocks", 0.1, "higher"
        ),
    ]


def number(
    name: str, value: float, unit: str, tolerance: float, better: str = "lower"
) -> Measurement:
    """Make a measurement; lower is better by default."""
    return Measurement(name=name, value=value, unit=unit, better=better, tolerance=tolerance)
