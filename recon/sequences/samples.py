"""Sample recordings from installed packages, without network access."""

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, ReconError, nearest
from recon.files import atomic_path

CALIBRATION = """\
cam0=[994.978 0 311.193; 0 994.978 254.877; 0 0 1]
cam1=[994.978 0 342.279; 0 994.978 254.877; 0 0 1]
doffs=31.086
baseline=193.001
width=741
height=500
ndisp=70
"""
"""From the docstring of `skimage.data.stereo_motorcycle`; the baseline is in millimetres."""
META = {
    "dataset": "Middlebury stereo 2014, Motorcycle, quarter size, as scikit-image ships it",
    "source": "skimage.data.stereo_motorcycle()",
    "terms": "cite Scharstein et al., High-resolution stereo datasets with subpixel-accurate "
    "ground truth, GCPR 2014",
    "truth": "disp_left.pfm: disparity of the left image in pixels, infinite where unknown",
    "truth_scale": 1,
}


def fetch(name: str, folder: Path) -> list[Path]:
    """Put a sample recording into a folder; files of its own that exist stay.

    Parameters
    ----------
    name : str
        "motorcycle": a pair with its calibration and true disparity.
    folder : Path
        Created if missing.

    Returns
    -------
    list of Path
        All files of the sample.

    Raises
    ------
    InputError
        For an unknown name, and for a folder with images or a calibration of another recording.
    """
    if name not in SAMPLES:
        known = ", ".join(SAMPLES)
        near = nearest(name, SAMPLES)
        raise InputError(f"sample is {name!r}, but one of {known} is needed (nearest: {near})")
    folder.mkdir(parents=True, exist_ok=True)
    return SAMPLES[name](folder)


def _motorcycle(folder: Path) -> list[Path]:
    calib = folder / "calib.txt"
    if calib.is_file() and calib.read_bytes() != CALIBRATION.encode():
        raise _foreign(calib)
    texts = {"calib.txt": CALIBRATION, "meta.json": json.dumps(META, indent=1) + "\n"}
    images = ("left.png", "right.png", "disp_left.pfm")
    if not all((folder / name).is_file() for name in images):
        from skimage.data import stereo_motorcycle

        left, right, disparity = stereo_motorcycle()
        found = (left[..., ::-1], right[..., ::-1], disparity.astype(np.float32))
        for name, image in zip(images, found, strict=True):
            if (folder / name).exists() and not _shows(folder / name, image):
                raise _foreign(folder / name)
        for name, image in zip(images, found, strict=True):
            _write_image(folder / name, image)
    for name, text in texts.items():
        if not (folder / name).is_file():
            with atomic_path(folder / name) as part:
                part.write_text(text, encoding="utf-8")
    return [folder / name for name in (*images, *texts)]


def _shows(path: Path, image: NDArray[np.generic]) -> bool:
    stored = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    return stored is not None and np.array_equal(stored, image)


def _foreign(path: Path) -> InputError:
    return InputError(f"{path} is of another recording; give another -o")


def _write_image(path: Path, image: NDArray[np.generic]) -> None:
    with atomic_path(path) as part:
        if not cv2.imwrite(str(part), image):
            raise ReconError(f"{path} could not be written")


SAMPLES: dict[str, Callable[[Path], list[Path]]] = {"motorcycle": _motorcycle}
