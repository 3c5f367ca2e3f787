"""Disparity in files: the true one of a pair folder, and a found one."""

import json
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.files import atomic_path


class DisparityTruth(NamedTuple):
    """What the left pixels' disparity really is."""

    disparity_px: NDArray[np.float64]
    """(H, W) of the left image, NaN where unknown."""
    quantisation_px: float
    """Step of the truth: a pixel where all is in whole pixels; 0 for floats."""


def read_truth(pair_dir: Path, truth_scale: float | None = None) -> DisparityTruth:
    """The truth `disp_left.*` of a pair folder; its scale is in meta.json unless given.

    Raises
    ------
    InputError
        Where there is no truth, or no scale of whole-numbered truth.
    """
    files = sorted(Path(pair_dir).glob("disp_left.*"))
    if not files:
        raise InputError(f"{pair_dir} holds no disp_left.* (.png, .pfm, .tif)")
    return read_truth_file(files[0], truth_scale)


def read_truth_file(path: Path, truth_scale: float | None = None) -> DisparityTruth:
    """Disparity of a file: floats as they are (scale 1), whole numbers by their scale.

    0 and what is not finite is unknown. Without `truth_scale`, whole numbers need the
    "truth_scale" of the meta.json beside the file.
    """
    stored = _read_numbers(path)
    whole = np.issubdtype(stored.dtype, np.integer)
    scale = truth_scale or (_scale_beside(path) if whole else 1.0)
    disparity = stored.astype(np.float64) / scale
    disparity[~np.isfinite(disparity) | (stored == 0)] = np.nan
    return DisparityTruth(disparity, _step_px(disparity, scale) if whole else 0.0)


def write_disparity(path: Path, disparity_px: NDArray[np.float64]) -> None:
    """Write a disparity (H, W) as PFM, what is unknown (NaN) as infinite, as Middlebury has it."""
    stored = np.where(np.isnan(disparity_px), np.inf, disparity_px).astype(np.float32)
    with atomic_path(path) as part:
        cv2.imwrite(str(part), stored)


def _step_px(disparity: NDArray[np.float64], scale: float) -> float:
    """A pixel where all truth is in whole pixels, else the step of the stored numbers."""
    known = disparity[np.isfinite(disparity)]
    return 1.0 if (known == np.rint(known)).all() else 1.0 / scale


def _read_numbers(path: Path) -> NDArray[np.generic]:
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from error
    numbers = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if data.size else None
    if numbers is None:
        raise InputError(f"{path} is no image of disparities")
    grey: NDArray[np.generic] = numbers if numbers.ndim == 2 else numbers[..., 0]
    return grey


def _scale_beside(path: Path) -> float:
    meta = path.parent / "meta.json"
    try:
        scale = float(json.loads(meta.read_text(encoding="utf-8"))["truth_scale"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{path} holds whole numbers, but {meta} tells no truth_scale: give --truth-scale"
        ) from error
    if not 0 < scale < np.inf:
        raise InputError(f"{meta} has truth_scale {scale}, but a positive number is needed")
    return scale
