"""The simulator's time relative to StereoSGBM, one thread, and the accuracy on its pairs."""

import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np

from benchmarks import Measurement
from recon.mapping.pair import match_pair
from recon.records import StereoPair, View
from recon.settings.settings import Settings
from recon.world.world import World

VILLAGE = Path(__file__).parents[2] / "scenes" / "village.scene"
COTTAGE = np.array([20.0, 5.0, -5.0])
MIN_DISPARITY, NUM_DISPARITIES = -10, 32


def measure(quick: bool) -> list[Measurement]:
    """Measure the time of a 256 x 256 pair with 2 x 2 samples and mipmaps, and its disparities."""
    # Open3D's threads ignore the environment variables.
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    cv2.setNumThreads(1)
    world = World.from_file(VILLAGE, Settings())
    views = list(orbit(COTTAGE, 17.0, 3 if quick else 9))
    return [speed(world, views), *disparities(world, views)]


def orbit(centre: np.ndarray, distance: float, count: int) -> Iterator[View]:
    """Make views around a point."""
    for angle in np.arange(count) * 2 * np.pi / count:
        around = distance * np.array([np.sin(angle), 0.0, np.cos(angle)])
        yield View(position=centre + around, target=centre)


def speed(world: World, views: list[View]) -> Measurement:
    """Median time of a pair, as a multiple of StereoSGBM's on the same pair in RGB."""
    ratios = []
    for view in views:
        pair = world.take(view)
        ratios.append(
            median_time(lambda v=view: world.take(v)) / median_time(lambda p=pair: sgbm(p))
        )
    return Measurement(
        name="world.pair_256x256_ratio",
        value=float(np.median(ratios)),
        unit="of StereoSGBM's time",
        better="lower",
        tolerance=0.2,
    )


def sgbm(pair: StereoPair) -> np.ndarray:
    """Disparities by OpenCV's semi-global matching, the peer."""
    matcher = cv2.StereoSGBM.create(MIN_DISPARITY, NUM_DISPARITIES, 5, 8 * 75, 32 * 75)
    return matcher.compute(pair.left, pair.right)


def median_time(call: Callable[[], object], repeats: int = 9) -> float:
    """Median seconds of a call, without the first one."""
    call()
    seconds = []
    for _ in range(repeats):
        began = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - began)
    return float(np.median(seconds))


def disparities(world: World, views: list[View]) -> list[Measurement]:
    """Error of phase stereo on objects of rendered pairs, against the rendered truth."""
    errors = np.abs(np.concatenate([disparity_errors(world, view) for view in views]))
    return [
        Measurement(
            name="world.disparity_error_median",
            value=float(np.median(errors)),
            unit="px",
            better="lower",
            tolerance=0.2,
        ),
        Measurement(
            name="world.disparity_error_over_half_px",
            value=float(100 * np.mean(errors > 0.5)),
            unit="percent of matches",
            better="lower",
            tolerance=0.5,
        ),
    ]


def disparity_errors(world: World, view: View) -> np.ndarray:
    """Found minus true disparity, in pixels, of the matches on objects."""
    pair, truth = world.take(view), world.truth(view)
    found = match_pair(
        pair.left, pair.right, min_disparity=MIN_DISPARITY, max_disparity=20, quality="fast"
    )
    u, v = np.rint(found.points_px).astype(int).T
    on_object = truth.object_id[v, u] >= 0
    true_px = pair.rig.disparity(truth.depth[v, u])
    return (found.disparity_px - true_px)[on_object]
