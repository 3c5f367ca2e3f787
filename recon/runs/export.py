"""Export of maps, clouds and meshes to other formats."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from recon.exports.content import inside, len_of
from recon.exports.format import Data, Up
from recon.exports.formats import format_of, holds_mesh, read_mesh, read_silently, write
from recon.exports.partitions.partitioned import PartitionedMap
from recon.exports.turning import R_YUP_ZUP, turned_points
from recon.files import check_target
from recon.manifest import MANIFEST
from recon.notices import collected_notices, notify
from recon.records import Mesh, PointCloud
from recon.runs.maps import map_path
from recon.runs.posed import POSED, export_poses

Box = tuple[tuple[float, ...], tuple[float, ...]]
_NAV2 = (".pgm", ".yaml", ".yml")


@dataclass(frozen=True, slots=True, kw_only=True)
class Selection:
    """Selection of the data to export, and options for reading."""

    box: Box | None = None
    """Low and high corner, in the axes of the source."""
    columns: Sequence[str] | None = None
    """Names of the columns of a table of text."""
    sample: int | None = None
    """Number of points sampled from a cloud or from the triangles of a mesh."""


def export_run(
    source: Path,
    target: Path,
    *,
    selection: Selection | None = None,
    up: Up | None = None,
    overwrite: bool = False,
) -> dict[str, Any]:
    """Write the content of `source` in the format of the suffix of `target`.

    Parameters
    ----------
    source : Path
        A file, a run folder, whose map is used, or a recording, whose cameras are written to
        images.txt (COLMAP) or transforms.json (nerfstudio).
    up : "y" or "z", optional
        The axis that is up in `target`; by default the format's own.

    Returns
    -------
    dict
        The document of `recon export --json`.
    """
    if target.name in POSED:
        return export_poses(source, target, overwrite=overwrite)
    source = (map_path(source) or source) if (source / MANIFEST).is_file() else source
    form = format_of(target)
    files = _files(target)
    for path in files:
        check_target(path, overwrite=overwrite, may_be_folder=True)
    with collected_notices() as notices:
        selection = selection or Selection()
        data = _read(source, target, selection)
        up_in, up_out = format_of(source).up, up or form.up
        if (up_in, up_out) == ("z", "y"):
            notify("turned-to-y-up", f"{target}: (x, y, z) of {source} is written as (x, z, -y)")
        if selection.box is not None:
            data = inside(data, _in_world(selection.box, up_in), target)
        write(data, target, up=up)
    parts = [path for path in (*target.rglob("*"), *files) if path.is_file()]
    return {
        "output": str(target),
        "up": up_out,
        "bytes": sum(path.stat().st_size for path in parts),
        _counted(data): len_of(data),
        "warnings": [notice.as_json() for notice in notices],
    }


def _read(source: Path, target: Path, selection: Selection) -> "Data | PartitionedMap":
    """Triangles if both formats support them and no sample is requested; else points or cells."""
    if selection.sample is None and format_of(target).write_mesh and holds_mesh(source):
        return read_mesh(source)
    return read_silently(source, columns=selection.columns, sample=selection.sample)


def _in_world(box: Box, up: Up) -> Box:
    """A box in a file's axes, converted to the world, which has y up."""
    if up == "y":
        return box
    corners = turned_points(np.array(box, np.float64), R_YUP_ZUP)
    return tuple(corners.min(axis=0).tolist()), tuple(corners.max(axis=0).tolist())


def _files(target: Path) -> list[Path]:
    """The files to write: an image with its description, a mesh with its materials."""
    if target.suffix.lower() == ".obj":
        return [target, target.with_suffix(".mtl")]
    if target.suffix.lower() not in _NAV2:
        return [target]
    is_image = target.suffix.lower() == ".pgm"
    description = target.with_suffix(".yaml") if is_image else target
    return [target.with_suffix(".pgm"), description]


def _counted(data: "Data | PartitionedMap") -> str:
    if isinstance(data, Mesh):
        return "num_triangles"
    return "num_points" if isinstance(data, PointCloud) else "num_cells"
