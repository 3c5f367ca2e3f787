"""A calibration file from images of a chessboard."""

from pathlib import Path
from typing import Any

from recon.errors import InputError
from recon.sequences.calibration.boards import calibrate, write_calibration


def calibrate_run(
    left_dir: Path,
    right_dir: Path,
    board: tuple[int, int],
    square: float,
    output: Path,
    *,
    overwrite: bool = False,
) -> dict[str, Any]:
    """Calibrate a rig and write its file.

    Returns
    -------
    dict
        The document of `recon calibrate --json`.
    """
    if output.exists() and not overwrite:
        raise InputError(f"{output} exists; give --overwrite or another -o")
    found = calibrate(left_dir, right_dir, board, square)
    write_calibration(found, output)
    return {
        "output": str(output),
        "rms_px": found.rms_px,
        "num_pairs": found.num_pairs,
        "skipped": [{"name": skip.name, "reason": skip.reason} for skip in found.skipped],
        "baseline": found.calibration.baseline,
    }
