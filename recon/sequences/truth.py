"""Disparity in files: the truth of a pair folder, and a computed disparity."""

from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.files.documents import read_json
from recon.sequences.images import ENDINGS as IMAGE_ENDINGS
from recon.sequences.images import MAX_BYTES, decode_pixels
from recon.sequences.pfm import decode_pfm, is_pfm
from recon.sequences.text import read_bytes

NAMES = ("disp_left", "disp0GT", "disp0", "disp1", "disp2", "disp_occ_0", "disp_occ", "disp_noc_0")
"""Names of recon, Middlebury 2014, 2005 and 2006 (view1), 2001 and 2003 (im2), and KITTI."""
ENDINGS = IMAGE_ENDINGS | {".pfm"}
KITTI_SCALE = 256.0


class DisparityTruth(NamedTuple):
    """True disparity of the left pixels."""

    disparity_px: NDArray[np.float64]
    """(H, W) of the left image, NaN where unknown."""
    quantisation_px: float
    """Quantisation step of the truth: 1 if all values are integers; 0 for floats."""


def read_truth(pair_dir: Path, truth_scale: float | None = None) -> DisparityTruth:
    """The truth `disp_left.*` of a pair folder, or by the names of Middlebury and KITTI.

    Its scale is in meta.json unless given.

    Raises
    ------
    InputError
        If there is no such folder, no truth in it, or no scale for integer truth.
    """
    if not Path(pair_dir).is_dir():
        raise InputError(
            f"{pair_dir} is not a folder, but one with left.*, right.* and disp_left.* is needed"
        )
    found = find_truth(Path(pair_dir))
    if found is None:
        raise InputError(f"{pair_dir} holds no disp_left.* (.png, .pfm, .tif)")
    return read_truth_file(found, truth_scale)


def find_truth(pair_dir: Path) -> Path | None:
    """The truth of the left image in a pair folder; None if it has none."""
    return next(filter(None, (_file_of(pair_dir, stem) for stem in NAMES)), None)


def _file_of(folder: Path, stem: str) -> Path | None:
    """The file of disparities by this name, whatever its format."""
    files = [f for f in sorted(folder.glob(f"{stem}.*")) if f.suffix.lower() in ENDINGS]
    return files[0] if files else None


def read_right_truth(
    pair_dir: Path, truth_scale: float | None = None
) -> NDArray[np.float64] | None:
    """(H, W) disparity of the right image's pixels, `disp_right.*`; None if there is none."""
    found = _file_of(pair_dir, "disp_right")
    return None if found is None else read_truth_file(found, truth_scale).disparity_px


def read_truth_file(path: Path, truth_scale: float | None = None) -> DisparityTruth:
    """The disparity of a file, as `read_disparity`, of which some has to be known."""
    truth = read_disparity(path, truth_scale)
    if not np.isfinite(truth.disparity_px).any():
        raise InputError(f"{path} contains no known disparity, but truth is needed")
    return truth


def read_disparity(path: Path, truth_scale: float | None = None) -> DisparityTruth:
    """Disparity of a file: floats unchanged (scale 1), integers divided by their scale.

    0 and non-finite values are unknown. Without `truth_scale`, integers need the "truth_scale" of
    the meta.json beside the file; for 16 bits without one it is KITTI's, 256.
    """
    stored = _read_numbers(path)
    whole = np.issubdtype(stored.dtype, np.integer)
    if truth_scale is None:
        truth_scale = _scale_beside(path, stored.dtype) if whole else 1.0
    # Signalling NaNs in 32 bits warn when cast.
    with np.errstate(invalid="ignore"):
        disparity = stored.astype(np.float64) / truth_scale
    disparity[~np.isfinite(disparity) | (stored == 0)] = np.nan
    return DisparityTruth(disparity, _step_px(disparity, truth_scale) if whole else 0.0)


def _step_px(disparity: NDArray[np.float64], scale: float) -> float:
    """1 if all values are integers, else the step of the stored numbers."""
    known = disparity[np.isfinite(disparity)]
    return 1.0 if (known == np.rint(known)).all() else 1.0 / scale


def _read_numbers(path: Path) -> NDArray[np.generic]:
    """(H, W) numbers of an image; several channels must be equal."""
    data = read_bytes(path, MAX_BYTES)
    numbers = decode_pfm(data, str(path)) if is_pfm(data) else _decode(data, path)
    if numbers.ndim == 2:
        return numbers
    colours = numbers[..., :3] if numbers.shape[2] > 2 else numbers[..., :1]
    if not (np.isfinite(colours) == np.isfinite(colours[..., :1])).all() or not np.array_equal(
        np.nan_to_num(colours), np.broadcast_to(np.nan_to_num(colours[..., :1]), colours.shape)
    ):
        raise InputError(
            f"{path} has {numbers.shape[2]} channels that differ, but one of disparities is needed"
        )
    one: NDArray[np.generic] = colours[..., 0]
    return one


def _decode(data: bytes, path: Path) -> NDArray[np.generic]:
    if data.startswith((b"II*\0", b"MM\0*")):  # TIFF may contain floats
        try:
            stored = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        except cv2.error as error:
            raise InputError(f"{path} has a size that cannot be read") from error
        if stored is not None:
            numbers: NDArray[np.generic] = stored
            return numbers
    try:
        return decode_pixels(data, str(path))
    except InputError as error:
        raise InputError(f"{path} is not an image of disparities ({error})") from error


def _scale_beside(path: Path, stored: np.dtype[np.generic]) -> float:
    meta = path.parent / "meta.json"
    if stored == np.uint16 and not meta.is_file():
        return KITTI_SCALE
    try:
        scale = float(read_json(meta)["truth_scale"])
    except (InputError, OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{path} contains whole numbers, but {meta} states no truth_scale: give --truth-scale"
        ) from error
    if not 0 < scale < np.inf:
        raise InputError(f"{meta} has truth_scale {scale}, but a positive number is needed")
    return scale
