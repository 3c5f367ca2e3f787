"""Files that are only read together with others: parts of folders, bags, videos, maps of two files.

Each reader gets a mutated part in its place among the valid ones.
"""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pyvista

from recon.exports import read, write
from recon.sequences import open_sequence
from recon.settings import SequenceSettings
from tests.exports.maps import sample_cloud, sample_map
from tests.sequences.recordings import image_pairs, kitti_rows, write_ros1, write_ros2

RECORDING = SequenceSettings(poses="none")


def contained_files(folder: Path) -> Iterator[tuple[str, Callable[[Path], Any], bytes]]:
    """Yield (name, reader, content) of each file."""
    for name, write_whole, pattern, read_whole in (
        (".meta.zarr", _write_zarr, "zarr.json", read),
        (".array.zarr", _write_zarr, "x/zarr.json", read),
        (".chunk.zarr", _write_zarr, "x/c/0", read),
        (".nav2.pgm", _write_nav2, "a.pgm", lambda path: read(path / "a.yaml")),
        (".nav2.yaml", _write_nav2, "a.yaml", lambda path: read(path / "a.yaml")),
        (".avi", _write_video, "both.avi", _pairs),
        (".bag", write_ros1, "drive.bag", _pairs),
        (".db3", write_ros2, "drive/drive.db3", lambda path: _pairs(path / "drive")),
        (".metadata.yaml", write_ros2, "drive/metadata.yaml", lambda path: _pairs(path / "drive")),
    ):
        whole = folder / f"of{name}"
        write_whole(whole)
        part = whole / pattern
        yield name, _in_its_place(part, whole, read_whole), part.read_bytes()
    for ending in (".e57", ".vtp", ".vtu"):
        yield ending, read, _alone(folder / f"sound{ending}").read_bytes()


def _in_its_place(
    part: Path, whole: Path, read_whole: Callable[[Path], Any]
) -> Callable[[Path], Any]:
    def read_mutated(path: Path) -> Any:
        shutil.copyfile(path, part)
        return read_whole(whole)

    return read_mutated


def _pairs(path: Path) -> Any:
    return list(open_sequence(path, RECORDING))


def _write_zarr(path: Path) -> None:
    write(sample_cloud(num=20), path)


def _write_nav2(path: Path) -> None:
    path.mkdir()
    write(sample_map(()).occupied(2), path / "a.yaml")


def _write_video(path: Path) -> None:
    path.mkdir()
    frames = [np.hstack(pair) for pair in image_pairs()][:2]
    video = cv2.VideoWriter(
        str(path / "both.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 1.0, frames[0].shape[::-1]
    )
    for frame in frames:
        video.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    video.release()
    (path / "calib.txt").write_text(kitti_rows())


def _alone(path: Path) -> Path:
    if path.suffix == ".e57":
        import pye57

        rng = np.random.default_rng(0)
        scan = pye57.E57(str(path), mode="w")
        scan.write_scan_raw({f"cartesian{axis}": rng.normal(size=20) for axis in "XYZ"})
        scan.close()
        return path
    shape = pyvista.Sphere(theta_resolution=5, phi_resolution=5)
    shape["heat"] = np.arange(float(shape.n_points))
    (shape if path.suffix == ".vtp" else shape.cast_to_unstructured_grid()).save(path, binary=False)
    return path
