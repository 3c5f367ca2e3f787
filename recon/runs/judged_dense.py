"""Evaluation of dense disparities on pairs with known truth, compared with OpenCV's matchers."""

import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.dense import kept_dense
from recon.records import DisparityMap
from recon.runs.arguments import positive
from recon.runs.evaluate import check_names, own_matching, searching
from recon.runs.figures import leave_figure
from recon.runs.job import Job, Kind, Numbers
from recon.runs.work import Work
from recon.sequences.pair_images import read_pair
from recon.sequences.readers.pair_dir import find_image
from recon.sequences.truth import DisparityTruth, read_right_truth, read_truth
from recon.settings import Settings
from recon.stereo.dense.cost import Search
from recon.stereo.dense.dense import match_every_pixel
from recon.stereo.dense.evaluation import judge
from recon.stereo.dense.peers import PEERS, SIGMA_PX
from recon.stereo.features import to_grey

Found = dict[str, tuple[DisparityMap, float]]
"""Disparities and their computation time in seconds, by matcher."""

OWN = "recon"


def _judge(job: Job, work: Work) -> Numbers:
    """Match every pixel of every pair by all matchers, and compare the results with the truth."""
    check_names(job.inputs)
    rows: list[dict[str, Any]] = []
    for number, path in enumerate(job.inputs, start=1):
        rows += _judge_pair(path, job, work)
        work.progress(number, len(job.inputs))
    return {"pairs": rows, "mean": _means(rows)}


def _judge_pair(path: Path, job: Job, work: Work) -> list[dict[str, Any]]:
    scale = job.arguments.get("truth_scale")
    truth = read_truth(path, scale)
    left, right = read_pair(*(find_image(path, side) for side in ("left", "right")))
    settings = searching(job.settings, own_matching(path, truth))
    with work.stage("stereo"):
        found = _matched(left, right, settings)
    if work.folder:
        maps = {name: one for name, (one, _) in found.items()}
        kept = kept_dense(left, maps, truth.disparity_px)
        with work.stage("figures"):
            for kind in ("dense_errors", "dense_sigmas"):
                leave_figure(work.folder.path, kind, kept, f"{path.resolve().name}_{kind}")
    return _rows(path, found, truth, scale)


def _matched(left: NDArray[np.uint8], right: NDArray[np.uint8], settings: Settings) -> Found:
    began = time.perf_counter()
    found = {OWN: (match_every_pixel(left, right, settings), time.perf_counter() - began)}
    asked = settings.matching
    search = Search(asked.min_disparity, asked.max_disparity - asked.min_disparity + 1)
    greys = to_grey(left), to_grey(right)
    for name, match in PEERS.items():
        began = time.perf_counter()
        disparity = match(*greys, search)
        seconds = time.perf_counter() - began
        sigma = np.where(np.isfinite(disparity), SIGMA_PX, np.float32(np.nan))
        found[name] = DisparityMap(disparity_px=disparity, sigma_px=sigma), seconds
    return found


def _rows(
    path: Path, found: Found, truth: DisparityTruth, scale: float | None
) -> list[dict[str, Any]]:
    right_px = read_right_truth(path, scale)
    rows = []
    for name, (one, seconds) in found.items():
        numbers: dict[str, Any] = judge(
            one, truth.disparity_px, truth.quantisation_px, right_px
        ).as_metrics()
        if name != OWN:
            # OpenCV provides no uncertainty.
            numbers |= {"within_1_sigma": None, "within_2_sigma": None}
        rows.append({"name": path.resolve().name, "matcher": name} | numbers | {"seconds": seconds})
    return rows


def _means(rows: list[dict[str, Any]]) -> dict[str, dict[str, float]]:
    """Mean of each metric over the pairs, by matcher."""
    means = {}
    for matcher in dict.fromkeys(row["matcher"] for row in rows):
        own = [row for row in rows if row["matcher"] == matcher]
        names = [name for name, value in own[0].items() if isinstance(value, float)]
        means[matcher] = {name: float(np.mean([row[name] for row in own])) for name in names}
    return means


DENSE = Kind(
    run=_judge, num_inputs=None, takes={"truth_scale": positive}, stages=("stereo", "figures")
)
"""`recon evaluate --dense`."""
