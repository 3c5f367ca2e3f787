"""Disparity maps and meshes: rejected values, areas, transformations and selections."""

import pickle

import numpy as np
import pytest

from recon.errors import InputError
from recon.geometry import pose, rotation_about_y
from recon.records import DisparityMap, Mesh

TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
SQUARE = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])


def square(**changed):
    parts = {
        "vertices": SQUARE,
        "triangles": TRIANGLES,
        "colours": np.arange(12, dtype=np.uint8).reshape(4, 3),
        "normals": np.tile([0.0, 0, 1], (4, 1)),
    }
    return Mesh(**parts | changed)


def test_area_is_the_sum_of_the_triangles():
    assert square().area == pytest.approx(4.0, abs=1e-12)
    np.testing.assert_allclose(square().triangle_areas, [2, 2], atol=1e-12)
    assert Mesh.none().area == 0
    assert len(Mesh.none()) == 0


def test_transformed_mesh_keeps_its_area_and_rotates_normals():
    T = pose(rotation_about_y(np.pi / 2), [1, 2, 3])
    moved = square().transformed(T)
    assert moved.area == pytest.approx(4.0, abs=1e-12)
    np.testing.assert_allclose(moved.normals, np.tile([1.0, 0, 0], (4, 1)), atol=1e-12)
    np.testing.assert_allclose(moved.vertices[0], [1, 2, 3], atol=1e-12)


def test_selected_triangles_keep_only_their_vertices():
    half = square().select(np.array([False, True]))
    assert half.triangles.tolist() == [[0, 1, 2]]
    np.testing.assert_array_equal(half.vertices, SQUARE[[0, 2, 3]])
    np.testing.assert_array_equal(half.colours[1], square().colours[2])


def test_mesh_survives_pickling():
    again = pickle.loads(pickle.dumps(square()))
    np.testing.assert_array_equal(again.triangles, TRIANGLES)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"triangles": TRIANGLES + 1}, "use the vertices 1 to 4, but there are 4"),
        ({"triangles": TRIANGLES - 1}, "use the vertices -1 to 2, but there are 4"),
        ({"triangles": TRIANGLES * 1.0}, "triangles are float64, but integers are needed"),
        ({"vertices": SQUARE * np.nan}, "vertices holds nan at flat index 0"),
        ({"colours": np.zeros((3, 3), np.uint8)}, r"colours has shape \(3, 3\), but \(4, 3\)"),
        ({"colours": np.zeros((4, 3))}, "colours are float64, but uint8 is needed"),
        ({"normals": np.zeros((4, 2))}, r"normals has shape \(4, 2\)"),
    ],
)
def test_inconsistent_array_of_a_mesh_is_named(changed, message):
    with pytest.raises(InputError, match=message):
        square(**changed)


def found(**changed):
    disparity = np.array([[1.0, np.nan], [3, 4]], np.float32)
    return DisparityMap(**{"disparity_px": disparity, "sigma_px": disparity * 0.1} | changed)


def test_disparity_map_gives_its_known_pixels():
    assert found().coverage == 0.75
    assert found().valid_mask.tolist() == [[True, False], [True, True]]
    fewer = found().where(np.array([[True, True], [False, True]]))
    assert fewer.valid_mask.tolist() == [[True, False], [False, True]]
    assert np.isnan(fewer.sigma_px[1, 0])


def test_sigma_is_known_exactly_where_disparity_is():
    with pytest.raises(InputError, match="sigma_px is not NaN exactly where disparity_px is"):
        found(sigma_px=np.ones((2, 2), np.float32))
    with pytest.raises(InputError, match=r"sigma_px has shape \(2, 3\), but \(2, 2\) is needed"):
        found(sigma_px=np.ones((2, 3), np.float32))
