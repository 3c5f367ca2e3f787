"""Planes that do not line what they are on, or go through it, are no roof and no back."""

import numpy as np
import pytest

from recon.recognition.naming import arrangement
from recon.recognition.naming.arrangement import lined, pierced
from recon.recognition.naming.catalogue import read_catalogues
from recon.recognition.naming.naming import name_object
from recon.recognition.naming.probability import Logistic
from recon.recognition.segments.flat_pieces import FlatPiece
from recon.recognition.synthetic import voxelise
from recon.records import Plane, PointCloud

KINDS = read_catalogues(["village"])
ALWAYS = Logistic(middle=-1e9, steepness=1.0)


def cells_of(points):
    return voxelise(PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8)))


def roofed(surfaces, rng, low, high):
    """Two walls with a slope over the rectangle between two corners (x, z)."""
    walls = np.array([0.0, 3.0, 0.0]) + surfaces.box(rng, [14.0, 6.0, 10.0], 9000)
    seen = (walls[:, 1] < 5.9) & ((walls[:, 0] < -6.9) | (walls[:, 2] < -4.9))
    x, z = rng.uniform(low, high, (2000, 2)).T
    slope = np.column_stack([x, 4.0 + 0.8 * (z - low[1]), z])
    points = np.concatenate([walls[seen], slope])
    voxels = cells_of(points + rng.normal(0.0, 0.1, points.shape))
    return voxels.select(voxels.centres[:, 1] >= 1.0)


def test_a_roof_lines_its_walls(surfaces, monkeypatch):
    corner = roofed(surfaces, np.random.default_rng(0), (-7.0, -5.0), (-3.5, -1.5))
    half = roofed(surfaces, np.random.default_rng(0), (-7.0, -5.0), (7.0, 0.0))
    assert name_object(half, 0.0, KINDS).label == "house"
    assert name_object(corner, 0.0, KINDS).label == "unknown"
    monkeypatch.setattr(arrangement, "ROOF", ALWAYS)
    assert name_object(corner, 0.0, KINDS).label == "house"


def piece(rows, normal, cells):
    own = cells.means[rows]
    plane = Plane(point=own.mean(axis=0), normal=np.array(normal))
    return FlatPiece(rows=rows, solid=plane, low=own.min(axis=0), high=own.max(axis=0))


def seat_and_back(low, high):
    """The pieces of a seat at a height of 4 and of a plane between two corners, and the cells."""
    rng = np.random.default_rng(0)
    seat = rng.uniform([-8.0, 4.0, -3.0], [8.0, 4.2, 3.0], (4000, 3))
    cells = cells_of(np.concatenate([seat, rng.uniform(low, high, (4000, 3))]))
    is_seat = abs(cells.means[:, 1] - 4.1) < 0.15
    return (
        piece(np.flatnonzero(is_seat), [0.0, 1.0, 0.0], cells),
        piece(np.flatnonzero(~is_seat), [0.0, 0.0, 1.0], cells),
        cells,
    )


@pytest.mark.parametrize(
    ("left", "right", "share"), [(-8.0, 8.0, 1.0), (-8.0, 0.0, 0.5), (4.0, 20.0, 0.25)]
)
def test_a_back_lines_its_seat_as_far_as_both_extend(left, right, share):
    seat, back, cells = seat_and_back([left, 4.3, -3.0], [right, 9.0, -2.8])
    found = lined([seat], [back], cells)
    assert found == pytest.approx(share, abs=0.06)


def test_a_level_plane_lines_what_it_covers():
    seat, _, cells = seat_and_back([-8.0, 4.3, -3.0], [8.0, 9.0, -2.8])
    assert lined([seat], [seat], cells) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("low", "depth", "low_share", "high_share"),
    [(4.2, -3.0, 0.0, 0.0), (4.2, 0.0, 0.0, 0.0), (0.2, -3.0, 0.0, 0.05), (0.2, 0.0, 0.3, 0.5)],
    ids=["at the edge", "on the middle", "behind the edge", "through the middle"],
)
def test_a_back_through_its_seat_pierces_it(low, depth, low_share, high_share):
    found = pierced(*seat_and_back([-8.0, low, depth], [8.0, 9.0, depth + 0.2]))
    assert low_share <= found <= high_share
