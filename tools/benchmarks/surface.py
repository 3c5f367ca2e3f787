"""Dense matching compared with OpenCV's MODE_HH on the golden pair, and its point cloud."""

from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from benchmarks import Measurement, cpu_seconds
from recon.libraries import limit_threads
from recon.records import DisparityMap, StereoPair
from recon.sequences.open import open_sequence
from recon.sequences.truth import read_truth_file
from recon.settings import Quality, SequenceSettings
from recon.stereo.dense.cost import Search
from recon.stereo.dense.dense import match_dense
from recon.stereo.dense.evaluation import judge
from recon.stereo.dense.peers import PEERS, SIGMA_PX
from recon.stereo.features import to_grey

PAIR = Path(__file__).parents[2] / "data" / "motorcycle"
HIGHEST = 79
QUALITIES: tuple[Quality, ...] = ("fast", "best")
DISTANCES = (0.01, 0.02, 0.05)
"""Metres from the true surface within which it counts as covered."""


def measure(quick: bool) -> list[Measurement]:
    """Measure time ratio, accuracy beside the peer, sigma, and coverage of the surface."""
    limit_threads(1)
    pair = next(iter(open_sequence(PAIR, SequenceSettings())))
    found = []
    peer = _peer(pair)
    for quality in QUALITIES:
        own = match_dense(pair.left, pair.right, max_disparity=HIGHEST, quality=quality)
        found += _against(quality, own, peer)
        found.append(_ratio(quality, pair, repeats=3 if quick else 9))
        found += _covered(quality, own, pair)
    return found + _covered("hh", peer, pair)


def _peer(pair: StereoPair) -> DisparityMap:
    greys = to_grey(pair.left), to_grey(pair.right)
    disparity = PEERS["hh"](*greys, Search(0, HIGHEST + 1))
    sigma = np.where(np.isfinite(disparity), SIGMA_PX, np.float32(np.nan))
    return DisparityMap(disparity_px=disparity, sigma_px=sigma)


def _against(quality: str, own: DisparityMap, peer: DisparityMap) -> list[Measurement]:
    truth = read_truth_file(PAIR / "disp_left.pfm").disparity_px
    ours, theirs = judge(own, truth), judge(peer, truth)
    return [
        _number(f"{quality}_right_nonocc_lead", ours.right_nonocc - theirs.right_nonocc, "points"),
        _number(f"{quality}_wrong_less", theirs.wrong - ours.wrong, "points"),
        _number(f"{quality}_median_ratio", ours.median_px / theirs.median_px, "of HH's", "lower"),
        _number(f"{quality}_covered_lead", ours.covered - theirs.covered, "points"),
        _number(f"{quality}_within_1_sigma", ours.within_1_sigma, "percent"),
        _number(f"{quality}_within_2_sigma", ours.within_2_sigma, "percent"),
    ]


def _ratio(quality: Quality, pair: StereoPair, repeats: int) -> Measurement:
    """Measure the CPU time of a whole pair relative to MODE_HH, alternating."""
    greys = to_grey(pair.left), to_grey(pair.right)

    def own() -> Any:
        return match_dense(pair.left, pair.right, max_disparity=HIGHEST, quality=quality)

    def peer() -> Any:
        return PEERS["hh"](*greys, Search(0, HIGHEST + 1))

    times = [(cpu_seconds(own), cpu_seconds(peer)) for _ in range(repeats)]
    ratio = median(a for a, _ in times) / median(b for _, b in times)
    return _number(f"{quality}_time_ratio", ratio, "of MODE_HH's time", "lower")


def _covered(name: str, found: DisparityMap, pair: StereoPair) -> list[Measurement]:
    """Measure the share of the true surface near a point, and the median distance of points."""
    truth = read_truth_file(PAIR / "disp_left.pfm").disparity_px
    true, own = (_points(pair, values) for values in (truth, found.disparity_px))
    to_own, to_true = cKDTree(own).query(true)[0], cKDTree(true).query(own)[0]
    shares = [
        _number(f"{name}_covered_{100 * d:g}cm", 100 * float(np.mean(to_own <= d)), "percent")
        for d in DISTANCES
    ]
    middle = _number(f"{name}_cloud_median", 1000 * float(np.median(to_true)), "mm", "lower")
    return [*shares, middle]


def _points(pair: StereoPair, disparity: Any) -> Any:
    v, u = np.nonzero(np.isfinite(disparity))
    points = pair.rig.triangulate(np.column_stack([u, v]), disparity[v, u])
    return points[np.isfinite(points).all(axis=1)]


def _number(name: str, value: float, unit: str, better: Any = "higher") -> Measurement:
    return Measurement(
        name=f"surface.{name}", value=value, unit=unit, better=better, tolerance=0.05
    )
