"""What a file or folder is, in a few facts."""

from pathlib import Path
from typing import Any

from recon.errors import InputError
from recon.exports.formats import read
from recon.records import Voxels
from recon.runfolder import MANIFEST, read_manifest
from recon.sequences.images import ENDINGS, read_image
from recon.sequences.open import open_sequence
from recon.settings import SequenceSettings
from recon.voxelmap import VoxelMap
from recon.world.scene import read_scene

Facts = dict[str, Any]


def describe(path: Path) -> Facts:
    """Facts about a run folder, recording, scene, image, map or cloud.

    Raises
    ------
    InputError
        Where nothing is at `path`, or nothing that recon knows.
    """
    if not path.exists():
        raise InputError(f"{path} does not exist")
    if path.is_dir() and path.suffix != ".zarr":
        return _of_run(path) if (path / MANIFEST).exists() else _of_recording(path)
    if path.suffix == ".scene":
        return _of_scene(path)
    if path.suffix.lower() in ENDINGS:
        return _of_image(path)
    return _of_points(path)


def _of_run(path: Path) -> Facts:
    manifest = read_manifest(path)
    names = ("command", "state", "error", "seed", "inputs", "versions", "seconds")
    return {"kind": "run"} | {name: manifest.get(name) for name in names}


def _of_recording(path: Path) -> Facts:
    source = open_sequence(path, SequenceSettings())
    pair = next(iter(source))
    rig = {name: getattr(pair.rig, name) for name in type(pair.rig).__slots__}
    return {
        "kind": "recording",
        "num_pairs": len(source),
        "skipped": len(source.skipped),
        "has_poses": pair.T_world_left is not None,
        "is_colour": pair.left.ndim == 3,
        "disparity_range": source.disparity_range,
    } | rig


def _of_scene(path: Path) -> Facts:
    scene = read_scene(path)
    return {
        "kind": "scene",
        "num_shaders": len(scene.shaders),
        "num_textures": len(scene.textures),
        "num_visuals": len(scene.visuals),
    }


def _of_image(path: Path) -> Facts:
    image = read_image(path)
    return {"kind": "image", "width": image.shape[1], "height": image.shape[0]} | {
        "is_colour": image.ndim == 3
    }


def _of_points(path: Path) -> Facts:
    data = read(path)
    if isinstance(data, VoxelMap):
        data = data.occupied(min_count=1)
    if isinstance(data, Voxels):
        facts: Facts = {"kind": "map", "num_cells": len(data), "cell_size": data.cell_size}
        return facts | {"num_points": int(data.counts.sum())} | _extent(data.means)
    return {"kind": "cloud", "num_points": len(data)} | _extent(data.points)


def _extent(points: Any) -> Facts:
    if not len(points):
        return {}
    return {"low": points.min(axis=0).tolist(), "high": points.max(axis=0).tolist()}
