"""Cells in figures: where they are drawn, in which colours, and how certain they are."""

from dataclasses import replace

import numpy as np
import pytest

from recon.figures.canvas import Sheet, pixels
from recon.figures.floor import draw_occupied, extent_of, floor_axes, show
from recon.figures.mapped import sigma_cells
from recon.figures.partition import PartCells
from recon.records import FoundObject, Part, PointCloud, Sphere, Voxels
from recon.voxelmap import VoxelMap


def two_balls():
    """A red ball under a blue one; the lower half of the blue ball's cells is red as well."""
    centres = np.array([[0.0, 2.0, 0.0], [0.0, 6.0, 0.0]])
    parts = tuple(
        Part(role=role, solid=Sphere(centre=at, radius=2.0), hue_deg=None, num_voxels=9, rms=0.1)
        for role, at in zip(("body", "roof"), centres, strict=True)
    )
    index = np.array([[x, y, z] for x in (-2, 1) for y in range(8) for z in (-2, 1)])
    is_blue = index[:, 1:2] >= 6
    return Voxels(
        index=index, centres=index + 0.5, means=index + 0.5, counts=np.full(len(index), 9),
        colours=np.where(is_blue, [[20, 20, 220]], [[220, 20, 20]]).astype(np.uint8),
        cell_size=1.0,
    ), FoundObject(
        id=0, label="cottage", probability=0.9, centre=np.array([0.0, 4.0, 0.0]),
        size=np.array([4.0, 8.0, 4.0]), num_voxels=len(index), parts=parts,
    )  # fmt: skip


def test_part_keeps_its_own_colour_where_two_parts_touch():
    voxels, found = two_balls()
    parts = PartCells.of(voxels, found)
    assert [parts.colour(number) for number in (0, 1)] == [(220, 20, 20), (20, 20, 220)]
    assert [len(parts.own(number)) for number in (0, 1)] == [16, 16]


@pytest.mark.parametrize(("hue_deg", "strongest"), [(0.0, 0), (120.0, 1), (240.0, 2), (None, None)])
def test_part_without_cells_has_the_colour_of_its_hue(hue_deg, strongest):
    voxels, found = two_balls()
    bare = replace(found, parts=(replace(found.parts[0], hue_deg=hue_deg),))
    colour = PartCells.of(voxels.select(slice(0)), bare).colour(0)
    others = [level for channel, level in enumerate(colour) if channel != strongest]
    assert len(set(others)) == 1
    assert strongest is None or colour[strongest] > 2 * others[0]


def test_cells_of_the_floor_are_drawn_where_they_are():
    index = np.array([[0, 0, 0], [6, 0, 0], [0, 0, 4]])
    cells = Voxels(
        index=index, centres=index + 0.5, means=index + 0.5, counts=np.ones(3, int), cell_size=1.0
    )  # fmt: skip
    sheet = Sheet.of((400, 300))
    axes = floor_axes(sheet, "", "m")
    draw_occupied(axes, cells, "#000000")
    show(axes, extent_of(cells))
    image = pixels(sheet.figure)
    at = axes.transData.transform([[0.5, 0.5], [6.5, 0.5], [0.5, 4.5], [6.5, 4.5]])
    levels = image[len(image) - at[:, 1].astype(int), at[:, 0].astype(int), 0]
    assert levels.tolist() == [0, 0, 0, 255]


def test_sigma_of_a_map_is_that_of_its_points():
    voxel_map = VoxelMap(0.5, channels=["weight"])
    places = np.array([[0.1, 0.1, 0.1], [3.1, 0.1, 0.1]])
    voxel_map.insert(PointCloud(points=places, sigma=np.array([0.05, 0.2])))
    np.testing.assert_allclose(sigma_cells(voxel_map.occupied(1)), [0.1, 0.4], rtol=1e-4)
