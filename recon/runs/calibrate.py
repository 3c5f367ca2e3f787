"""Calibration from images of a board, and rectification of images by a calibration."""

from pathlib import Path
from typing import Any

from recon.files import check_target
from recon.notices import collected_notices
from recon.sequences.calibration.boards import calibrate, write_calibration
from recon.sequences.calibration.targets import parse_target
from recon.sequences.rectified_images import rectify_files


def calibrate_run(
    left_dir: Path,
    right_dir: Path,
    board: str,
    square: float,
    output: Path,
    *,
    overwrite: bool = False,
    force: bool = False,
) -> dict[str, Any]:
    """Calibrate a rig and write its file.

    Returns
    -------
    dict
        The document of `recon calibrate --json`.
    """
    check_target(output, overwrite=overwrite)
    with collected_notices() as notices:
        found = calibrate(left_dir, right_dir, parse_target(board, square), force=force)
    write_calibration(found.calibration, output, found.rms_px)
    return {
        "output": str(output),
        "rms_px": found.rms_px,
        "num_pairs": found.num_pairs,
        "dropped": [*found.dropped],
        "skipped": [{"name": skip.name, "reason": skip.reason} for skip in found.skipped],
        "baseline": found.calibration.baseline,
        "warnings": [notice.as_json() for notice in notices],
    }


def rectify_run(
    left: Path, right: Path, calib: Path, output: Path, *, overwrite: bool = False
) -> dict[str, Any]:
    """Rectify images and write them with their calibration.

    Returns
    -------
    dict
        The document of `recon rectify --json`.
    """
    check_target(output, overwrite=overwrite, may_be_folder=True)
    with collected_notices() as notices:
        done = rectify_files(left, right, calib, output)
    rig = done.rig
    return {
        "output": str(output),
        "num_pairs": done.num_pairs,
        "skipped": [*done.skipped],
        "size": [rig.width, rig.height],
        "focal_px": rig.focal_px,
        "principal_point_px": [rig.cx_left_px, rig.cy_px],
        "baseline": rig.baseline,
        "warnings": [notice.as_json() for notice in notices],
    }
