"""One view as a folder of files that any stereo program can read."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.files import atomic_path
from recon.geometry import Array
from recon.records import StereoPair


def export_frame(pair: StereoPair, depth: Array, folder: str | Path) -> None:
    """Write left.png, right.png, disp_left.pfm (infinite = unknown) and calib.txt (Middlebury)."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    disparity_px = np.where(np.isnan(depth), np.inf, pair.rig.disparity(depth))
    _write_image(folder / "left.png", pair.left[..., ::-1])
    _write_image(folder / "right.png", pair.right[..., ::-1])
    _write_image(folder / "disp_left.pfm", disparity_px.astype(np.float32))
    with atomic_path(folder / "calib.txt") as beside:
        beside.write_text(middlebury_calibration(pair.rig))


def middlebury_calibration(rig: StereoRig) -> str:
    """The text of a Middlebury calibration, whose baseline is in thousandths."""
    left, right = (
        f"[{rig.focal_px!r} 0 {cx!r}; 0 {rig.focal_px!r} {rig.cy_px!r}; 0 0 1]"
        for cx in (rig.cx_left_px, rig.cx_right_px)
    )
    return (
        f"cam0={left}\ncam1={right}\ndoffs={rig.cx_right_px - rig.cx_left_px!r}\n"
        f"baseline={1000.0 * rig.baseline!r}\nwidth={rig.width}\nheight={rig.height}\n"
        f"residual_px={rig.residual_px!r}\n"
    )


def _write_image(path: Path, image: NDArray[np.uint8] | NDArray[np.float32]) -> None:
    with atomic_path(path) as beside:
        cv2.imwrite(str(beside), image)
