"""Descriptions of JSON, TOML, YAML and text, distinguished by their content."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exports.columns import MAX_COORDINATE
from recon.exports.text import names_points
from recon.files.documents import read_json, read_text, read_toml, read_yaml
from recon.recognition.naming.catalogue import read_catalogue
from recon.records import Trajectory
from recon.records.objects import from_json
from recon.runs.description.facts import Facts, extent, table
from recon.runs.description.points import of_points
from recon.runs.description.recordings import of_calibration
from recon.sequences.calibration.rows import is_middlebury
from recon.sequences.pose_files import read_poses
from recon.sequences.poses import GivenPoses
from recon.settings import Settings, updated
from recon.stereo.matching.vonmises import load_model

_OBJECT = ("id", "label", "probability", "centre", "size", "num_voxels")
_MODEL_FORMAT = "format"


def of_json(path: Path) -> Facts:
    """Objects, metrics, a manifest, a model of a matcher, or a calibration."""
    document = read_json(path)
    if not isinstance(document, dict):
        raise InputError(f"{path}: contains a {type(document).__name__}, not a document of recon")
    if "objects" in document:
        return of_objects(document)
    if "frames" in document:
        return of_trajectory(path)
    if _MODEL_FORMAT in document:
        return _of_model(path)
    if {"command", "state"} <= document.keys():
        return {"kind": "manifest"} | _plain(document)
    if {"num_pairs", "num_points", "num_features", "pairs", "jobs"} & document.keys():
        return of_metrics(document)
    return of_calibration(path)


def of_objects(document: Mapping[str, Any]) -> Facts:
    """The objects, one row for each."""
    objects = document["objects"]
    if not isinstance(objects, list) or not all(isinstance(one, dict) for one in objects):
        raise InputError("objects are not a list of objects of recon")
    try:
        from_json(dict(document))
    except (KeyError, TypeError, AttributeError, ValueError, IndexError) as error:
        raise InputError(f"objects are damaged ({error!r})") from error
    return {
        "kind": "objects",
        "num_objects": len(objects),
        "objects": table(objects, _OBJECT),
        "failures": document.get("failures", {}),
    }


def of_metrics(document: Mapping[str, Any]) -> Facts:
    """The metrics of a run; for long lists only their length."""
    return {"kind": "metrics"} | _plain(document)


def _plain(document: Mapping[str, Any]) -> Facts:
    return {
        name: f"{len(value)} rows" if isinstance(value, list) and len(value) > 20 else value
        for name, value in document.items()
        if name not in ("kind", "warnings")
    }


def _of_model(path: Path) -> Facts:
    model = load_model(str(path))
    return {
        "kind": "model",
        "matcher": "vonmises",
        "widths_px": list(model.widths_px),
        "num_bins": int(model.share_right.shape[1]),
    }


def of_toml(path: Path) -> Facts:
    """Settings, a catalogue of names, or jobs of a batch."""
    document = read_toml(path)
    if "object" in document:
        kinds = read_catalogue(path)
        return {"kind": "catalogue", "num_names": len(kinds), "names": [one.name for one in kinds]}
    if "job" in document:
        jobs = document["job"]
        rows = jobs if isinstance(jobs, list) and all(isinstance(j, dict) for j in jobs) else []
        return {"kind": "jobs", "num_jobs": len(rows)} | {
            "jobs": table(rows, ("name", "command", "input"))
        }
    updated(Settings(), document, str(path))
    return {"kind": "settings"} | document


def of_yaml(path: Path) -> Facts:
    """The description of a nav2 map, or a calibration."""
    try:
        document = read_yaml(path)
    except InputError:
        document = None
    if isinstance(document, dict) and {"image", "resolution"} <= document.keys():
        return of_points(path)
    return of_calibration(path)


def of_text(path: Path) -> Facts:
    """A calibration, a trajectory or a table of points: the first that fits."""
    if names_points(path):
        return of_points(path)
    if is_middlebury(read_text(path).splitlines()):
        return of_calibration(path)
    faults = []
    for described in (of_calibration, of_trajectory, of_points):
        try:
            return described(path)
        except InputError as error:
            faults.append(str(error).removeprefix(f"{path}: "))
    raise InputError(f"{path}: not a calibration, trajectory or table of points ({faults[-1]})")


def of_trajectory(path: Path) -> Facts:
    """Poses, with the length and the time range of the path."""
    found = _poses(path)
    if not len(found):
        raise InputError(f"{path}: contains no poses")
    places = found.poses[:, :3, 3]
    if np.abs(places).max() > MAX_COORDINATE:
        raise InputError(f"{path}: a pose is {np.abs(places).max():g} away")
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    facts: Facts = {"kind": "trajectory", "num_poses": len(places), "length": float(steps.sum())}
    if found.stamps_s is not None:
        facts |= {"first_s": float(found.stamps_s[0]), "last_s": float(found.stamps_s[-1])}
    return facts | extent(places)


def _poses(path: Path) -> GivenPoses:
    """Poses of a run, whose times may repeat, or of any other file."""
    try:
        own = Trajectory.from_tum(read_text(path), str(path))
    except InputError:
        return read_poses(path)
    return GivenPoses(poses=own.T_world_left, stamps_s=own.stamps_s)
