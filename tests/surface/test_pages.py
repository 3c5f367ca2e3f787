"""Regions of a surface on disk: memory is bounded, and the surface stays the same to the byte."""

import numpy as np
import pytest
from views import ball_view, mesh_of, wall_view

from recon.errors import InputError
from recon.exports.formats import write, write_parts
from recon.surface import pages
from recon.surface.cells import CELL, CellCloud, joined
from recon.surface.pages import Pages, regions_of
from recon.surface.volume import Volume

VOXEL, CELL_SIZE = 0.04, 0.02


def views():
    """A ball seen from all around, so that its regions leave and re-enter the view."""
    return [ball_view(angle, noise=0.01, sigma=0.02) for angle in (0, 90, 180, 270, 20)]


def fused(folder=None, chosen=slice(None)):
    volume, cells = (
        Volume(VOXEL, folder and folder / "a"),
        CellCloud(CELL_SIZE, folder and folder / "b"),
    )
    for view in views()[chosen]:
        volume.add(view)
        cells.add(view)
    return volume, cells


def bytes_of(volume, cells):
    mesh, cloud = mesh_of(volume), joined(cells)
    assert len(mesh) > 3_000
    arrays = mesh.vertices, mesh.triangles, cloud.points, cloud.sigma, cloud.attributes["views"]
    return [array.tobytes() for array in (*arrays, cells.colours_at(mesh.vertices))]


@pytest.fixture(scope="module")
def held():
    return bytes_of(*fused())


def test_pages_on_disk_bound_memory_and_change_no_byte(held, tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "HELD_BYTES", 1 << 19)
    volume, cells = fused(tmp_path)
    for table in (volume.pages, cells.pages):
        assert len(table.keys) >= 8
        assert len(list(table.folder.iterdir())) >= 3
        largest = max(table.page(key).nbytes for key in table.keys)
        assert sum(one.nbytes for one in table._held.values()) < (1 << 19) + largest
    assert bytes_of(volume, cells) == held


def test_cloud_written_by_region_equals_the_whole(tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "HELD_BYTES", 1 << 19)
    _, cells = fused(tmp_path)
    assert len(list(cells)) > 8
    assert len(cells) == sum(map(len, cells))
    write_parts(cells, len(cells), tmp_path / "parts.ply")
    write(joined(cells), tmp_path / "whole.ply")
    assert (tmp_path / "parts.ply").read_bytes() == (tmp_path / "whole.ply").read_bytes()
    with pytest.raises(InputError, match="the format needs all points at once"):
        write_parts(cells, len(cells), tmp_path / "parts.pcd")


def test_volumes_of_subsets_of_views_add_up(held, tmp_path):
    for name, chosen in {"late": slice(3, None), "early": slice(3)}.items():
        for kind, part in zip(("volume", "cells"), fused(chosen=chosen), strict=True):
            part.pages.save(tmp_path / name / kind)
    volume, cells = Volume(VOXEL), CellCloud(CELL_SIZE)
    for name in ("early", "late"):
        volume.merge(tmp_path / name / "volume")
        cells.merge(tmp_path / name / "cells")
    assert bytes_of(volume, cells)[2:5] == held[2:5]
    # The views of one subset carve no blocks that only the other subset has allocated.
    whole = {one.tobytes() for one in np.frombuffer(held[0]).reshape(-1, 3)}
    assert np.mean([one.tobytes() in whole for one in mesh_of(volume).vertices]) > 0.95
    alone, _ = fused(chosen=slice(3))
    assert np.mean([one.tobytes() in whole for one in mesh_of(alone).vertices]) < 0.9


def test_missing_view_changes_the_surface(held, tmp_path):
    volume, cells = fused(chosen=slice(4))
    assert bytes_of(volume, cells) != held


def test_region_is_read_with_its_neighbouring_cells():
    table = Pages(CELL, 4)
    for key, rows in regions_of(index := np.mgrid[-8:8, -8:8, -8:8].reshape(3, -1).T, 4):
        table.page(key).enter(index[rows])
    assert table.keys == sorted(table.keys)
    assert len(table.keys) == 64
    found = table.around((0, -1, 1), 2).used["index"]
    np.testing.assert_array_equal(found.min(axis=0), [-2, -6, 2])
    np.testing.assert_array_equal(found.max(axis=0), [5, 1, 7])
    assert len(found) == 8 * 8 * 6


def test_every_cell_is_in_exactly_one_region():
    index = np.random.default_rng(0).integers(-300, 300, (500, 3)).astype(np.int32)
    seen = np.zeros(500, int)
    for key, rows in regions_of(index, 128):
        seen[rows] += 1
        assert (index[rows] // 128 == key).all()
    assert (seen == 1).all()
    assert not list(regions_of(index[:0], 128))


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("0_0_0.npy", b"junk", "not a whole"),
        ("0_0_0.npy", np.zeros(3), "cells of a page are needed"),
        ("wall.npy", np.zeros(0, CELL), "its name is not x_y_z.npy"),
    ],
)
def test_invalid_page_is_rejected(tmp_path, name, content, message):
    if isinstance(content, bytes):
        (tmp_path / name).write_bytes(content)
    else:
        np.save(tmp_path / name, content)
    with pytest.raises(InputError, match=message):
        CellCloud(1.0).merge(tmp_path)


def test_voxel_of_saturated_weight_stays_unchanged():
    volume = Volume(0.1)
    volume.add(wall_view(4.0, sigma=0.01))
    (key, *_) = volume.pages.keys
    block = volume.pages.page(key).used[0]
    block["weight"][:] = 2**31 - 5
    before = block["distance"].copy()
    volume.add(wall_view(4.0, sigma=0.01))
    assert (volume.pages.page(key).used[0]["weight"] == 2**31 - 5).all()
    np.testing.assert_array_equal(volume.pages.page(key).used[0]["distance"], before)
