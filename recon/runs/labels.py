"""Labelled occupancy as data: footprints for GIS, a map with labels for robots."""

import json
from pathlib import Path
from typing import Any

from recon.errors import InputError
from recon.exports import nav2
from recon.figures.geojson import feature_collection, flat
from recon.figures.kinds import Subject
from recon.files import atomic_path
from recon.notices import notify


def write_labels(folder: Path, subject: Subject) -> list[Path]:
    """Write labels.geojson, map.pgm with map.yaml for nav2, and labels.json for that map.

    Both have north up: their x is the world's, their y is -z. If the map has no cells at the height
    of a robot, the map and its labels are omitted with a notice.
    """
    run = subject.mapped
    shown = feature_collection(
        run.voxels, run.objects, run.trajectory.T_world_left, subject.unit
    )  # fmt: skip
    _write_json(folder / "labels.geojson", shown)
    try:
        nav2.write(folder / "map.pgm", run.map if subject.has_rays else run.voxels)
    except InputError as error:
        # A map of a few views may contain only ground; the footprints are still valid.
        notify("map-empty", str(error))
        return [folder / "labels.geojson"]
    _write_json(folder / "labels.json", _labels(shown, run.objects, subject.unit))
    return [folder / name for name in ("labels.geojson", "map.pgm", "map.yaml", "labels.json")]


def _labels(shown: dict[str, Any], objects: Any, unit: str) -> dict[str, Any]:
    """Names by position in the frame of map.yaml."""
    rings = {
        one["properties"]["id"]: one["geometry"]["coordinates"][0]
        for one in shown["features"]
        if one["geometry"]["type"] == "Polygon"
    }
    return {
        "map": "map.yaml",
        "unit": unit,
        "labels": [
            {
                "id": found.id,
                "label": found.label,
                "probability": found.probability,
                "position": flat(found.centre[None, [0, 2]])[0],
                "footprint": rings[found.id],
            }
            for found in objects
        ],
    }


def _write_json(path: Path, document: object) -> None:
    with atomic_path(path) as part:
        part.write_text(json.dumps(document, indent=2, allow_nan=False) + "\n", encoding="utf-8")
