"""Two images matched, and held against the truth where there is one."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.disparity import dense as draw_dense
from recon.figures.disparity import disparity as draw_disparity
from recon.files import atomic_path
from recon.mapping.pair import match_features
from recon.records import Matches, check_images
from recon.runs.figures import write_figures
from recon.runs.order import RunOrder
from recon.runs.products import as_document, write_metrics
from recon.runs.report import read_json
from recon.sequences.calibration.files import read_calibration
from recon.sequences.images import read_image
from recon.sequences.truth import DisparityTruth, read_truth_file, write_disparity
from recon.settings import Settings
from recon.stereo.dense.dense import densify
from recon.stereo.evaluation import evaluate, evaluate_map
from recon.stereo.features import detect


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MatchedPair:
    """Matches of two images and what it took."""

    left: NDArray[np.uint8]
    matches: Matches
    num_features: int
    seconds: float
    dense_px: NDArray[np.float64] | None
    """(H, W) disparity of every pixel, NaN = unknown, where the settings want it."""


def match_files(left_path: Path, right_path: Path, settings: Settings) -> MatchedPair:
    """Match two image files as the settings say."""
    left, right = read_image(left_path), read_image(right_path)
    check_images(left, right, f"{left_path} and {right_path}")
    began = time.perf_counter()
    features = detect(left, settings.features), detect(right, settings.features)
    matches = match_features(*features, settings)
    seconds = time.perf_counter() - began
    dense = densify(matches, *features, left, settings.dense) if settings.dense.enabled else None
    return MatchedPair(
        left=left, matches=matches, num_features=len(features[0]), seconds=seconds, dense_px=dense
    )


def search_range(calib_path: Path) -> dict[str, Any]:
    """The search range that a calibration states, by "stage.name"; empty where it does not."""
    stated = read_calibration(calib_path).disparity_range
    if stated is None:
        return {}
    return {"matching.min_disparity": stated[0], "matching.max_disparity": stated[1]}


def disparity_run(
    left_path: Path,
    right_path: Path,
    settings: Settings,
    *,
    order: RunOrder | None = None,
    truth_path: Path | None = None,
    truth_scale: float | None = None,
) -> dict[str, Any]:
    """Match two images; leave a run folder where one is ordered.

    Returns
    -------
    dict
        The document of `recon disparity --json`.
    """
    inputs = tuple(path for path in (left_path, right_path, truth_path) if path)
    run = order and order.folder("disparity", settings, inputs)
    if run and run.is_finished:
        return dict(read_json(run.path / "metrics.json"))
    pair = match_files(left_path, right_path, settings)
    truth = None if truth_path is None else read_truth_file(truth_path, truth_scale)
    metrics = as_document(measure(pair, truth))
    if run:
        with run.opened():
            write_matches(run.path / "matches.npz", pair.matches)
            figures = {"disparity": draw_disparity(pair.left, pair.matches)}
            if pair.dense_px is not None:
                write_disparity(run.path / "dense.pfm", pair.dense_px)
                figures["dense"] = draw_dense(pair.left, pair.dense_px)
            write_figures(run.path, figures)
            write_metrics(run, metrics)
    return metrics


def measure(pair: MatchedPair, truth: DisparityTruth | None) -> dict[str, Any]:
    """The numbers of one pair by their JSON keys."""
    metrics: dict[str, Any] = {
        "num_features": pair.num_features,
        "num_matches": len(pair.matches),
        "seconds": pair.seconds,
    }
    if pair.dense_px is not None:
        metrics["dense_coverage"] = float(np.isfinite(pair.dense_px).mean())
    if truth is None:
        return metrics
    metrics |= evaluate(pair.matches, truth.disparity_px, truth.quantisation_px).as_metrics()
    if pair.dense_px is not None:
        judged = evaluate_map(pair.dense_px, truth.disparity_px, truth.quantisation_px)
        metrics |= {f"dense_{name}": value for name, value in judged.as_metrics().items()}
    return metrics


def write_matches(path: Path, matches: Matches) -> None:
    """Write `matches.npz`, most confident first."""
    names = ("points_px", "disparity_px", "sigma_px", "score")
    with atomic_path(path) as part:
        np.savez_compressed(part, **{name: getattr(matches, name) for name in names})
