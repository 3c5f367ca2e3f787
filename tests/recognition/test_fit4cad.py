"""Parts of CAD models: the right type, and parameters within one percent."""

import json

import numpy as np
import pytest

from recon.recognition.fitting.shapes import fit
from recon.records import TruncatedCone


def errors(found, truth, points):
    """Compute relative errors of size and position, and sines of angles."""
    if truth["type"] == "Sphere":
        place = np.linalg.norm(found.centre - truth["center"])
        return [found.radius / truth["radius"] - 1, place / truth["radius"]]
    if truth["type"] == "Plane":
        off = (np.array(truth["point"]) - found.point) @ found.normal
        return [sine(found.normal, truth["normal"]), off / np.ptp(points, axis=0).max()]
    if truth["type"] == "Cylinder":
        offset = np.array(truth["axis_point"]) - found.point
        across = np.linalg.norm(offset - offset @ found.axis * found.axis)
        turned = sine(found.axis, truth["axis"])
        return [found.radius / truth["radius"] - 1, across / truth["radius"], turned]
    return [half_angle_deg(found) / truth["half_angle_deg"] - 1, sine(found.axis, truth["axis"])]


def sine(a, b):
    return np.linalg.norm(np.cross(a, b))


def half_angle_deg(cone):
    if isinstance(cone, TruncatedCone):
        return np.degrees(np.arctan2(cone.radius_bottom - cone.radius_top, cone.height))
    return np.degrees(cone.half_angle_rad)


@pytest.mark.data
def test_parts_of_cad_models_are_fitted(data_dir):
    told, exact, count = 0, 0, 0
    for folder in sorted((data_dir / "pointclouds").glob("fit4cad_*")):
        cloud = np.load(folder / "cloud.npz")
        for truth in json.loads((folder / "primitives.json").read_text()):
            if truth["type"] not in ("Sphere", "Cylinder", "Cone", "Plane"):
                continue
            points = cloud["xyz"][cloud["label"] == truth["id"]].astype(float)
            found = fit(points)
            count += 1
            if found and found.kind.removeprefix("truncated ") == truth["type"].lower():
                told += 1
                exact += np.abs(errors(found, truth, points)).max() < 0.01
    assert count == 41
    assert told >= 0.95 * count
    assert exact >= 0.95 * count
