"""Labelled occupancy as data: footprints for geographers, a map with labels for robots."""

import json
from pathlib import Path
from typing import Any

from recon.exports import nav2
from recon.figures.geojson import feature_collection, flat
from recon.figures.kinds import Subject
from recon.files import atomic_path


def write_labels(folder: Path, subject: Subject) -> list[Path]:
    """Write labels.geojson, map.pgm with map.yaml for nav2, and labels.json for that map.

    Both have north up: their x is the world's, their y is -z.
    """
    run = subject.mapped
    shown = feature_collection(
        run.voxels, run.objects, run.trajectory.T_world_left, subject.unit
    )  # fmt: skip
    _write_json(folder / "labels.geojson", shown)
    nav2.write(folder / "map.pgm", run.map if subject.has_rays else run.voxels)
    _write_json(folder / "labels.json", _labels(shown, run.objects, subject.unit))
    return [folder / name for name in ("labels.geojson", "map.pgm", "map.yaml", "labels.json")]


def _labels(shown: dict[str, Any], objects: Any, unit: str) -> dict[str, Any]:
    """Names by place in the frame of map.yaml."""
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
