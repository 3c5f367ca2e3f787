"""Visible and hidden parts of an object, including parts that no view shows."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.recognition.fitting.composite import Composite
from recon.recognition.fitting.surface_points import area, surface
from recon.records import Box, Solid, Voxels

Array = NDArray[np.float64]

UNSEEN = 0.1
"""A part is unseen if its cell density is below this share of that of the best seen part."""
LARGEST_TO_EXTENT = 1.4
"""A fit larger than this multiple of the extent of its cells is rejected: even one view shows a
quarter of a round object, whose chord is 0.7 of its width."""
HOVERING = 0.15
"""Height of an object's lowest cell above the ground, as a share of its height: an object that
hovers higher is supported by something unseen."""
NEAR_CELLS = 1.25
"""Maximum distance, in cells, of a cell that covers a surface point."""
NUM_PLACES = 200
"""Sampled surface points per part: its share is accurate to 0.035."""
HIDDEN = 0.05
"""A face of which less than this share has cells on it is hidden, not open."""
TRUNK = 0.3
"""Radius of an unseen body, as a share of its crown's."""


def is_hovering(cells: Voxels, ground: float) -> bool:
    """True if no cell is near the ground."""
    low, high = cells.means[:, 1].min(), cells.means[:, 1].max()
    return bool(low - ground > HOVERING * (high - ground) + 2.0 * cells.cell_size)


def unseen_parts(composite: Composite, cells: Voxels) -> NDArray[np.bool_]:
    """Mask (parts,) of parts with nearly no cells for their surface."""
    _, nearest = composite.nearest(cells.means)
    counts = np.bincount(nearest, minlength=len(composite.shapes))
    density = counts / np.maximum(composite.areas, cells.cell_size**2)
    unseen: NDArray[np.bool_] = density < UNSEEN * density.max()
    return unseen


def is_whole(composite: Composite, cells: Voxels) -> bool:
    """True if the composite has the cells' size and all parts above the lowest are visible."""
    extent = float(np.ptp(cells.means, axis=0).max())
    within = max(2.0 * composite.widest.max(), composite.heights[-1] - cells.means[:, 1].min())
    unseen = unseen_parts(composite, cells)[1:]
    return bool(within < LARGEST_TO_EXTENT * extent and not unseen.any())


def with_thin_body(composite: Composite, cells: Voxels) -> Composite:
    """The composite with its lowest part limited to the width of a trunk if it is unseen."""
    if not unseen_parts(composite, cells)[0] or not len(composite.radii[0]):
        return composite
    radius = np.minimum(composite.radii[0], TRUNK * composite.widest[1:].max(initial=0.0))
    return replace(composite, radii=(radius, *composite.radii[1:]))


def coverage(parts: Sequence[Solid], cells: Voxels, near_cells: float = NEAR_CELLS) -> Array:
    """Share (parts,) of the surface of each solid with a cell nearby."""
    tree = cKDTree(cells.means)
    reach = near_cells * cells.cell_size
    shares = []
    for part in parts:
        if area(part) <= 0.0:
            shares.append(0.0)
            continue
        places = surface([part], NUM_PLACES, np.random.default_rng(0)).points
        distances, _ = tree.query(places, distance_upper_bound=reach)
        shares.append(float(np.isfinite(distances).mean()))
    return np.array(shares)


def filled_faces(box: Box, cells: Voxels, near_cells: float) -> float:
    """Share of the faces of a box that has a cell on it, of those that are seen at all.

    The sides of a table hold its legs, and are open between them; those of a box are filled, or
    hidden.
    """
    places = surface([box], 6 * NUM_PLACES, np.random.default_rng(0)).points
    reach = near_cells * cells.cell_size
    is_near = np.isfinite(cKDTree(cells.means).query(places, distance_upper_bound=reach)[0])
    local = (places - box.centre) @ box.axes.T / box.sizes
    side = np.argmax(np.abs(local), axis=1)
    face = 2 * side + (local[np.arange(len(local)), side] > 0)
    shares = np.bincount(face, is_near, 6) / np.maximum(np.bincount(face, minlength=6), 1)
    seen = (shares > HIDDEN)[face]
    return float(is_near[seen].mean()) if seen.any() else 0.0
