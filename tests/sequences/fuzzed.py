"""Small valid images, calibrations and poses for the fuzzer, each with its reader."""

import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import PIL.Image

from recon.sequences.calibration.files import read_calibration
from recon.sequences.images import read_image
from recon.sequences.pose_files import read_poses
from recon.sequences.timestamps import read_times
from recon.sequences.truth import read_truth_file
from tests.sequences import test_calibration_files as calibrations

POSES = {
    ".vins.csv": "#t,x,y,z,qw,qx,qy,qz\n1000000000,0,0,0,1,0,0,0\n1050000000,1,0,0,1,0,0,0\n",
    ".colmap.txt": "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 1 0 0 1 b.png\n\n",
    ".nerf.json": '{"frames": [{"file_path": "a", "transform_matrix": '
    "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}",
}  # fmt: skip
CALIBRATIONS = {
    ".kalibr.yaml": calibrations.kalibr("T_cam_imu"),
    ".opencv.yaml": calibrations.HEAD + calibrations.CAMERAS + calibrations.STEP,
    ".opencv.xml": calibrations.XML,
    ".orbslam3.yaml": calibrations.HEAD + calibrations.ORB3,
    ".okvis.yaml": calibrations.OKVIS,
    ".raw.txt": calibrations.RAW,
}


def valid_files() -> Iterator[tuple[str, Callable[[Path], Any], bytes]]:
    """Yield (name, reader, content) of each file."""
    rng = np.random.default_rng(0)
    image = cv2.GaussianBlur(rng.integers(0, 256, (20, 30, 3), np.uint8), (0, 0), 2)
    for ending, form in ((".tga", "TGA"), (".bmp", "BMP"), (".webp", "WEBP"), (".ppm", "PPM")):
        yield ending, read_image, encoded(image, form)
    yield ".progressive.jpg", read_image, encoded(image, "JPEG", progressive=True)
    deep = image[..., 0].astype(np.uint16) * 16
    for name in (".deep.png", ".deep.tif"):
        yield name, read_image, cv2.imencode(name[5:], deep)[1].tobytes()
    yield ".truth.pfm", read_truth_file, b"Pf\n4 3\n-1.0\n" + np.ones(12, "<f4").tobytes()
    for name, text in CALIBRATIONS.items():
        yield name, read_calibration, text.encode()
    for name, text in POSES.items():
        yield name, read_poses, text.encode()
    yield ".times.txt", read_times, b"0.0\n0.1\n2011-09-26 13:02:25.96\n"


def encoded(image: np.ndarray, form: str, **options: Any) -> bytes:
    stream = io.BytesIO()
    PIL.Image.fromarray(image).save(stream, form, **options)
    return stream.getvalue()
