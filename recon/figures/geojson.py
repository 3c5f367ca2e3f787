"""Labelled occupancy as data: GeoJSON of footprints, in the map's own metres.

GeoJSON's x is the world's x, its y is -z, so that north, which is ahead, is up. RFC 7946 allows
degrees only; `crs` states that these are lengths, as in GeoJSON 2008 and as readers expect.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import footprints
from recon.records import FoundObject, Voxels

Array = NDArray[np.float64]

DIGITS = 6


def feature_collection(
    voxels: Voxels, objects: Sequence[FoundObject], trajectory: Array | None = None, unit: str = ""
) -> dict[str, Any]:
    """One polygon per object, and the path of the camera as a line.

    Parameters
    ----------
    voxels : Voxels
        Occupied cells.
    objects : sequence of FoundObject
    trajectory : (N, 4, 4), optional
        `T_world_left` of every pair.
    unit : str
        Of lengths.
    """
    features = [_footprint(found, voxels) for found in objects]
    if trajectory is not None and len(trajectory) > 1:
        way = flat(trajectory[:, :3, 3][:, [0, 2]])
        features.append(_feature("LineString", way, {"role": "way of the left camera"}))
    return {
        "type": "FeatureCollection",
        "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC::LocalCS"}},
        "axes": {"x": "world x", "y": "world -z", "unit": unit},
        "features": features,
    }


def flat(points_xz: Array) -> list[list[float]]:
    """Coordinates (x, -z) of points (N, 2) in x, z."""
    turned = points_xz * (1.0, -1.0)
    # No minus zero: it would be another text for the same position.
    rows: list[list[float]] = (np.round(turned, DIGITS) + 0.0).tolist()
    return rows


def _footprint(found: FoundObject, voxels: Voxels) -> dict[str, Any]:
    ring = flat(footprints.of_object(found, voxels))
    bottom = float(found.centre[1] - found.size[1] / 2.0)
    properties = {
        "id": found.id,
        "label": found.label,
        "probability": found.probability,
        "centre": flat(found.centre[None, [0, 2]])[0],
        "bottom": round(bottom, DIGITS),
        "height": round(float(found.size[1]), DIGITS),
        "parts": [part.solid.kind for part in found.parts],
    }
    return _feature("Polygon", [[*ring, ring[0]]], properties)


def _feature(kind: str, coordinates: Any, properties: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "Feature",
        "geometry": {"type": kind, "coordinates": coordinates},
        "properties": properties,
    }
