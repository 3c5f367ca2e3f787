"""Descriptions of recordings, bags, images, disparities, calibrations and scenes."""

from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.runs.description.facts import Facts, spread
from recon.sequences.calibration.files import read_calibration
from recon.sequences.images import read_pixels
from recon.sequences.open import find_recording, name_of, open_recorded
from recon.sequences.readers.bag import is_bag
from recon.sequences.readers.bag_file import connections
from recon.sequences.truth import read_disparity
from recon.settings import SequenceSettings
from recon.world.scene import read_scene


def of_recording(path: Path) -> Facts:
    """A recording; for a bag without identifiable cameras, only its topics."""
    found = find_recording(path)
    topics = _topics(path if found is None else found[1])
    try:
        return _of_pairs(path, None if found is None else name_of(found[0])) | topics
    except InputError as error:
        if not topics:
            raise
        return {"kind": "bag", "pairs": None, "reason": str(error)} | topics


def _topics(path: Path) -> Facts:
    if not is_bag(path):
        return {}
    rows = [{"topic": t, "type": kind, "messages": num} for t, kind, num in connections(path)]
    return {"topics": rows}


def _of_pairs(path: Path, form: str | None) -> Facts:
    source = open_recorded(path, SequenceSettings())
    pair = next(iter(source), None)
    if pair is None:
        raise InputError(f"{path} contains no readable pair")
    rig = {name: getattr(pair.rig, name) for name in type(pair.rig).__slots__}
    return {
        "kind": "recording",
        "format": form,
        "num_pairs": len(source),
        "skipped": len(source.skipped),
        "has_poses": pair.T_world_left is not None,
        "is_colour": pair.left.ndim == 3,
        "disparity_range": source.disparity_range,
    } | rig


def of_scene(path: Path) -> Facts:
    """A geometry file."""
    scene = read_scene(path)
    return {
        "kind": "scene",
        "num_shaders": len(scene.shaders),
        "num_textures": len(scene.textures),
        "num_visuals": len(scene.visuals),
    }


def of_image(path: Path) -> Facts:
    """An image as stored."""
    image = read_pixels(path)
    return {
        "kind": "image",
        "width": image.shape[1],
        "height": image.shape[0],
        "is_colour": image.ndim == 3,
        "bits": 8 * image.dtype.itemsize,
    } | spread("levels", image.astype(np.float64))


def of_disparity(path: Path) -> Facts:
    """A dense disparity, or its standard deviation."""
    values = read_disparity(path).disparity_px
    return {
        "kind": "disparity",
        "width": values.shape[1],
        "height": values.shape[0],
        "known": float(np.isfinite(values).mean()),
    } | spread("disparity_px", values)


def of_calibration(path: Path) -> Facts:
    """Two cameras."""
    found = read_calibration(path)
    width, height = found.size or (None, None)
    return {
        "kind": "calibration",
        "width": width,
        "height": height,
        "baseline": found.baseline,
        "is_rectified": found.is_rectified,
        "focal_length_px": [float(c.matrix[0, 0]) for c in (found.left, found.right)],
        "principal_point_px": [c.matrix[:2, 2].tolist() for c in (found.left, found.right)],
        "num_distortion": [len(c.distortion) for c in (found.left, found.right)],
        "disparity_range": found.disparity_range,
    }
