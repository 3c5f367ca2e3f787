"""The thesis's recogniser, unmodified: hue parts, quadrics on cell centres, three rules (4.5)."""

import numpy as np

from recon.recognition.colour import mean_hue_deg
from recon.recognition.fitting.quadrics import half_axes_sq, quadric_shape, thesis_quadric
from recon.recognition.fitting.shapes import from_points
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.naming import Naming, unknown
from recon.recognition.segments.segmentation import grow_hue
from recon.records import FitFailure, Part, Voxels

MIN_PART = 9
"""Minimum cells of a part: a quadric has nine unknowns."""


def name_by_quadrics(
    voxels: Voxels, ground: float, kinds: tuple[Kind, ...], tolerance_deg: float
) -> Naming:
    """Name an object by the shapes of its two largest hue segments, the lower one its body."""
    label = grow_hue(voxels, tolerance_deg).label
    parts = [voxels.select(label == number) for number in range(min(2, int(label.max()) + 1))]
    if len(parts) < 2 or len(parts[1]) < MIN_PART:
        return unknown(voxels, ground, "hue shows fewer than two parts")
    parts.sort(key=lambda part: float(part.means[:, 1].mean()))
    shapes = [_shape(part) for part in parts]
    for shape in shapes:
        if isinstance(shape, FitFailure):
            return unknown(voxels, ground, shape.reason)
    ratio = _width(parts[0]) / max(_width(parts[1]), 1e-9)
    for kind in kinds:
        if _fulfils(kind, [str(shape) for shape in shapes], ratio):
            return _named(voxels, ground, kind, parts, [str(shape) for shape in shapes])
    return unknown(voxels, ground, f"{shapes[1]} on {shapes[0]} is not a kind of the catalogue")


def _shape(part: Voxels) -> str | FitFailure:
    squares = half_axes_sq(thesis_quadric(part.centres))
    return squares if isinstance(squares, FitFailure) else quadric_shape(squares)


def _width(part: Voxels) -> float:
    return float(np.ptp(part.centres[:, ::2], axis=0).mean())


def _fulfils(kind: Kind, shapes: list[str], ratio: float) -> bool:
    allowed = [part.shapes for part in kind.parts]
    low, high = kind.ratio or (0.0, np.inf)
    fits = all(shape in some for shape, some in zip(shapes, allowed, strict=False))
    return len(allowed) == len(shapes) and fits and low <= ratio <= high


def _named(
    voxels: Voxels, ground: float, kind: Kind, parts: list[Voxels], shapes: list[str]
) -> Naming:
    low, high = voxels.means.min(axis=0), voxels.means.max(axis=0)
    low[1] = ground
    found = [
        _part(rule.role, part, shape)
        for rule, part, shape in zip(kind.parts, parts, shapes, strict=True)
    ]
    return Naming(
        label=kind.name,
        probability=1.0,
        centre=(low + high) / 2.0,
        size=high - low,
        parts=tuple(part for part in found if part is not None),
    )


def _part(role: str, cells: Voxels, shape: str) -> Part | None:
    """The part with a solid of its shape; None if none can be fitted to its cells."""
    fit = from_points(shape, cells.means)
    if isinstance(fit, FitFailure):
        return None
    hue = mean_hue_deg(cells.shown_colours)
    return Part(role=role, solid=fit.solid, hue_deg=hue, num_voxels=len(cells), rms=fit.rms)
