"""The cameras of a recording for COLMAP (images.txt) and nerfstudio (transforms.json)."""

from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.notices import collected_notices
from recon.sequences.open import open_sequence
from recon.sequences.posed_images import write_colmap, write_nerfstudio
from recon.settings import SequenceSettings

COLMAP, NERFSTUDIO = "images.txt", "transforms.json"
POSED = (COLMAP, NERFSTUDIO)
"""Names of files that hold poses of images."""


def export_poses(source: Path, target: Path, *, overwrite: bool = False) -> dict[str, Any]:
    """Write poses and intrinsics of the rectified left images of a recording.

    COLMAP's cameras.txt and points3D.txt are written beside its images.txt.

    Returns
    -------
    dict
        The document of `recon export --json`.
    """
    if target.exists() and not overwrite:
        raise InputError(f"{target} exists; give --overwrite or another name")
    with collected_notices() as notices:
        pairs = open_sequence(source, SequenceSettings())
        seen = [(pair.name, pair.T_world_left, pair.rig) for pair in pairs]
    rigs = {rig for _, _, rig in seen}
    if len(rigs) > 1:
        raise InputError(f"{source} has {len(rigs)} cameras, but one is needed for {target.name}")
    names = [f"left/{name}.png" for name, _, _ in seen]
    poses = np.array([T_world_left for _, T_world_left, _ in seen], dtype=np.float64)
    if target.name == COLMAP:
        write_colmap(target.parent, names, poses, rigs.pop())
    else:
        write_nerfstudio(target, names, poses, rigs.pop())
    return {
        "output": str(target),
        "up": "y",
        "bytes": target.stat().st_size,
        "num_poses": len(names),
        "warnings": [notice.as_json() for notice in notices],
    }
