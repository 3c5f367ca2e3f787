"""A format: points as lines of a .jsonl file."""

import json
from pathlib import Path

import numpy as np

import recon
from recon.exports.format import Format
from recon.files import atomic_path


def write(path: Path, cloud: recon.PointCloud) -> None:
    """One line per point: x, y, z."""
    lines = [json.dumps(point) for point in cloud.points.tolist()]
    with atomic_path(path) as part:
        part.write_text("\n".join(lines), encoding="utf-8")


def read(path: Path) -> recon.PointCloud:
    """The points; such a file has no colours."""
    try:
        rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
        points = np.asarray(rows, dtype=np.float64).reshape(len(rows), 3)
    except (TypeError, ValueError) as error:
        raise recon.InputError(f"{path}: {error}, but lines of [x, y, z] are needed") from error
    return recon.PointCloud(points=points)


JSON_LINES = Format(read=read, write=write, takes=(recon.PointCloud,))
