"""Matching of two images, and evaluation if there is ground truth."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.figures.kept import kept_pair
from recon.figures.kinds import Arrays
from recon.files import atomic_path
from recon.mapping.sparse import match_sparse
from recon.records import DisparityMap, Matches, check_images
from recon.runfolder import RunFolder
from recon.runs.arguments import path, positive
from recon.runs.figures import leave_figure
from recon.runs.job import Job, Kind, Numbers, Tree
from recon.runs.work import Work
from recon.sequences.calibration.cameras import Calibration
from recon.sequences.calibration.files import read_calibration
from recon.sequences.calibration.rectification import rectifier
from recon.sequences.contradictions.pairs import check_images as check_contradictions
from recon.sequences.contradictions.truth import check_truth
from recon.sequences.pair_images import read_pair
from recon.sequences.pfm import write_pfm
from recon.sequences.truth import DisparityTruth, read_truth_file
from recon.settings import Settings
from recon.stereo.dense.dense import match_every_pixel
from recon.stereo.evaluation import evaluate, evaluate_map
from recon.stereo.features import detect

MISMATCHED = {
    "left-right-swapped", "not-simultaneous", "images-unrelated", "image-blank", "same-image",
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MatchedPair:
    """Matches of two images, with statistics."""

    left: NDArray[np.uint8]
    matches: Matches
    num_features: int
    seconds: float
    dense: DisparityMap | None
    """Disparity of every pixel, if enabled by the settings."""
    is_mismatched: bool
    """True if the images are not left and right of one moment: no truth fits them."""


def match_files(
    left_path: Path, right_path: Path, settings: Settings, calib: Path | None = None
) -> MatchedPair:
    """Match two image files as the settings say; with a calibration they are rectified first."""
    left, right = read_pair(left_path, right_path)
    check_images(left, right, f"{left_path} and {right_path}")
    if calib is not None:
        rectify = rectifier(read_calibration(calib), (left.shape[1], left.shape[0]))
        left, right = rectify(left, right)
    matching = settings.matching
    search = matching.min_disparity, matching.max_disparity
    contradictions = check_contradictions(left, right, search)
    began = time.perf_counter()
    found = match_sparse(left, right, settings)
    seconds = time.perf_counter() - began
    num_features = found.num_features
    if num_features is None:
        num_features = len(detect(left, settings.features))
    dense = match_every_pixel(left, right, settings) if settings.dense.enabled else None
    return MatchedPair(
        left=left,
        matches=found.matches,
        num_features=num_features,
        seconds=seconds,
        dense=dense,
        is_mismatched=bool(contradictions & MISMATCHED),
    )


def _base(job: Job) -> Tree:
    """The settings that the job's calibration states."""
    calib = job.arguments.get("calib")
    return {} if calib is None else {"matching": matching_of(read_calibration(calib))}


def matching_of(calibration: Calibration) -> Numbers:
    """The settings of matching that follow from a calibration."""
    stated: Numbers = {"residual_px": calibration.residual_px}
    if calibration.disparity_range is not None:
        stated["min_disparity"], stated["max_disparity"] = calibration.disparity_range
    return stated


def _match(job: Job, work: Work) -> Numbers:
    """Match two images, and compare them with the truth if it is known."""
    left, right = job.inputs
    truth = _truth(job)
    with work.stage("stereo"):
        pair = match_files(left, right, job.settings, calib=job.arguments.get("calib"))
    if work.folder:
        _write(work.folder, pair, work)
    return measure(pair, truth)


def _truth(job: Job) -> DisparityTruth | None:
    """The truth of the left image, refused if a calibration rectifies the images."""
    calib, file, scale = (job.arguments.get(name) for name in ("calib", "truth", "truth_scale"))
    if file is None:
        if scale is not None:
            raise InputError(f"truth_scale is {scale:g}, but there is no truth: give --truth")
        return None
    if calib is not None and not read_calibration(calib).is_rectified:
        raise InputError(
            f"{file} belongs to the raw images, but {calib} rectifies them: give one of them"
        )
    return read_truth_file(file, scale)


def _write(run: RunFolder, pair: MatchedPair, work: Work) -> None:
    with work.stage("write"):
        write_matches(run.path / "matches.npz", pair.matches)
        if pair.dense is not None:
            write_pfm(run.path / "dense.pfm", pair.dense.disparity_px)
            write_pfm(run.path / "dense_sigma.pfm", pair.dense.sigma_px)
    with work.stage("figures"):
        leave_figure(run.path, "disparity", kept_pair(pair.left, pair.matches.probable()))
        if pair.dense is not None:
            arrays: Arrays = {"left": pair.left, "disparity_px": pair.dense.disparity_px}
            leave_figure(run.path, "dense", arrays)


def measure(
    pair: MatchedPair,
    truth: DisparityTruth | None,
    truth_right_px: NDArray[np.float64] | None = None,
) -> dict[str, Any]:
    """The metrics of one pair by their JSON keys."""
    metrics: dict[str, Any] = {
        "num_features": pair.num_features,
        "num_matches": len(pair.matches),
        "seconds": pair.seconds,
    }
    if pair.dense is not None:
        metrics["dense_coverage"] = pair.dense.coverage
    if truth is None:
        return metrics
    if not pair.is_mismatched:
        check_truth(pair.left, pair.matches, truth)
    judged = evaluate(pair.matches, truth.disparity_px, truth.quantisation_px, truth_right_px)
    metrics |= judged.as_metrics()
    if pair.dense is not None:
        judged = evaluate_map(pair.dense.disparity_px, truth.disparity_px, truth.quantisation_px)
        metrics |= {f"dense_{name}": value for name, value in judged.as_metrics().items()}
    return metrics


def write_matches(path: Path, matches: Matches) -> None:
    """Write `matches.npz`, most confident first."""
    names = ("points_px", "disparity_px", "sigma_px", "score", "probability")
    with atomic_path(path) as part:
        np.savez_compressed(part, **{name: getattr(matches, name) for name in names})


DISPARITY = Kind(
    run=_match,
    num_inputs=2,
    base=_base,
    takes={"truth": path, "truth_scale": positive, "calib": path},
)
