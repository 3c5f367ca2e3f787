"""Reading point clouds compared with Open3D, in one run on one file."""

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks import Measurement
from recon.exports import read, write
from recon.libraries import load_open3d
from recon.records import PointCloud


def measure(quick: bool) -> list[Measurement]:
    """Measure the time of recon's PLY reader relative to Open3D's."""
    num = 200_000 if quick else 5_000_000
    rng = np.random.default_rng(0)
    cloud = PointCloud(
        points=rng.normal(scale=100.0, size=(num, 3)),
        colours=rng.integers(0, 256, (num, 3)).astype(np.uint8),
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cloud.ply"
        write(cloud, path)
        return [ply_ratio(path, 2 if quick else 5)]


def ply_ratio(path: Path, repeats: int) -> Measurement:
    """Alternate both readers, so that other load affects both; the fastest runs count."""
    o3d = load_open3d()
    readers: list[Callable[[], object]] = [
        lambda: read(path),
        lambda: o3d.t.io.read_point_cloud(str(path)),
    ]
    ours, theirs = np.min([[seconds(one) for one in readers] for _ in range(repeats)], axis=0)
    return Measurement(
        name="exports.ply_read_ratio",
        value=float(ours / theirs),
        unit="of Open3D's time",
        better="lower",
        tolerance=0.25,
    )


def seconds(call: Callable[[], object]) -> float:
    """Measure the wall time of one call."""
    began = time.perf_counter()
    call()
    return time.perf_counter() - began
