"""Exposed faces: none between neighbours, all outward, in the colour of their cell."""

import numpy as np
import pytest

from recon.records import Voxels
from recon.voxelmap.faces import exposed_faces


def voxels_of(index, cell_size=1.0):
    index = np.asarray(index, np.int64).reshape(-1, 3)
    centres = (index + 0.5) * cell_size
    colours = np.arange(3 * len(index), dtype=np.uint8).reshape(-1, 3)
    return Voxels(
        index=index, centres=centres, means=centres, counts=np.ones(len(index), np.int64),
        colours=colours, cell_size=cell_size,
    )  # fmt: skip


def test_single_cell_has_six_outward_faces():
    faces = exposed_faces(voxels_of([[2, -3, 4]], cell_size=0.5))
    assert len(faces) == 6
    edge = faces.vertices[:, 1] - faces.vertices[:, 0]
    other = faces.vertices[:, 3] - faces.vertices[:, 0]
    normals = np.cross(edge, other)
    outward = faces.vertices.mean(axis=1) - np.array([2.5, -2.5, 4.5]) * 0.5
    assert np.allclose(np.linalg.norm(normals, axis=1), 0.25)
    assert ((normals * outward).sum(axis=1) > 0).all()
    assert np.allclose(np.linalg.norm(outward, axis=1), 0.25)


@pytest.mark.parametrize("seed", range(3))
def test_faces_are_those_without_a_neighbour(seed):
    rng = np.random.default_rng(seed)
    index = np.unique(rng.integers(-3, 4, (120, 3)), axis=0)
    cells = {tuple(cell) for cell in index.tolist()}
    faces = exposed_faces(voxels_of(index))
    wanted = {
        (x, y, z, dx, dy, dz)
        for x, y, z in cells
        for dx, dy, dz in [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
        if (x + dx, y + dy, z + dz) not in cells
    }
    own = index[faces.cell]
    directions = np.rint(2 * (faces.vertices.mean(axis=1) - own - 0.5)).astype(int)
    assert {tuple(row) for row in np.hstack([own, directions]).tolist()} == wanted
    assert len(faces) == len(wanted)
    assert np.array_equal(faces.colours, voxels_of(index).colours[faces.cell])


def test_no_cells_give_no_faces():
    assert len(exposed_faces(voxels_of([]))) == 0


def test_cells_at_opposite_limits_are_not_neighbours():
    far = 2**31 - 2
    assert len(exposed_faces(voxels_of([[-far, -far, -far], [far, far, far]]))) == 12
