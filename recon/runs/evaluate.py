"""Many pairs with known truth, matched and judged side by side (Tables 1 and 3)."""

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.runs.disparity import match_files, measure
from recon.runs.products import Progress, as_document
from recon.sequences.calibration import read_calibration
from recon.sequences.folder import find_calibration
from recon.sequences.pair_dir import find_picture
from recon.sequences.truth import DisparityTruth, read_truth
from recon.settings import Settings, updated
from recon.stereo.evaluation import coverage

# Searched beyond the largest true disparity where no calibration states a range.
MARGIN_PX = 4


def evaluate_run(
    pair_dirs: Iterable[Path],
    settings: Settings,
    matchers: Iterable[str],
    *,
    search: dict[str, Any] | None = None,
    truth_scale: float | None = None,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Judge every matcher on every pair.

    Parameters
    ----------
    pair_dirs : iterable of Path
        Folders with left.*, right.* and disp_left.*.
    settings : Settings
    matchers : iterable of str
    search : dict, optional
        `min_disparity` and `max_disparity`; each pair's own where not given.
    truth_scale : float, optional
        Stored truth / this = disparity; each pair's own where not given.

    Returns
    -------
    dict
        The document of `recon evaluate --json`.
    """
    jobs = [(pair_dir, matcher) for pair_dir in pair_dirs for matcher in matchers]
    rows = []
    for pair_dir, matcher in jobs:
        truth = read_truth(pair_dir, truth_scale)
        changes = (search or own_range(pair_dir, truth)) | {"matcher": matcher}
        rows.append(_row(pair_dir, truth, updated(settings, {"matching": changes})))
        if progress is not None:
            progress(len(rows), len(jobs))
    return {"pairs": rows}


def own_range(pair_dir: Path, truth: DisparityTruth) -> dict[str, Any]:
    """The search range of a pair: its calibration's, else a little more than its truth holds."""
    try:
        stated = read_calibration(find_calibration(pair_dir)).disparity_range
    except InputError:
        stated = None
    low, high = stated or (0, math.ceil(np.nanmax(truth.disparity_px)) + MARGIN_PX)
    return {"min_disparity": low, "max_disparity": high}


def _row(pair_dir: Path, truth: DisparityTruth, settings: Settings) -> dict[str, Any]:
    left, right = (find_picture(pair_dir, side) for side in ("left", "right"))
    pair = match_files(left, right, settings)
    names = {"name": pair_dir.resolve().name, "matcher": settings.matching.matcher}
    shares = {"coverage": coverage(pair.matches, pair.left.shape[:2])}
    return as_document(names | measure(pair, truth) | shares)
