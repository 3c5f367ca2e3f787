"""Angles between upright planes: walls meet at right angles, faces of a rock at any."""

from collections.abc import Sequence

import numpy as np

from recon.recognition.segments.flat_pieces import FlatPiece
from recon.records import Plane

ALIKE = 0.5
"""Minimum cosine of the angle between the normals of planes that are no two walls of a corner."""


def squareness(pieces: Sequence[FlatPiece]) -> float:
    """The squareness of planes seen from above; 1 = all are parallel or at right angles.

    The length of the mean of unit vectors with four times the azimuth of the normals, in which
    quarter turns cancel; each plane counts as much as it has cells. Several planes without a corner
    are not square at all: the two sides of a hedge, or slices of it.
    """
    planes = [(one.solid.normal, len(one.rows)) for one in pieces if isinstance(one.solid, Plane)]
    if not planes:
        return 1.0
    normals, counts = np.array([normal for normal, _ in planes]), [count for _, count in planes]
    if len(planes) > 1 and np.abs(normals @ normals.T).min() > ALIKE:
        return 0.0
    turns = 4.0 * np.arctan2(normals[:, 2], normals[:, 0])
    return float(abs(np.average(np.exp(1j * turns), weights=counts)))
