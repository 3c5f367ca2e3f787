"""Figures: right size, the right colours in the right places, the same bytes twice."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.figures import topview
from recon.figures.canvas import save_png
from recon.figures.disparity import dense, disparity
from recon.figures.map3d import map3d
from recon.figures.matching import error_map
from recon.figures.mixture import mixture
from recon.records import FoundObject, Matches, Voxels


@pytest.fixture
def voxels():
    """A red column and a blue one, ten cells apart along x."""
    index = np.array([[x, y, 0] for x in (0, 10) for y in range(4)])
    colours = np.where(index[:, :1] == 0, [[220, 20, 20]], [[20, 20, 220]]).astype(np.uint8)
    return Voxels(
        index=index, centres=index + 0.5, means=index + 0.5, counts=np.full(8, 9),
        colours=colours, cell_size=1.0,
    )  # fmt: skip


@pytest.fixture
def nothing(voxels):
    return voxels.select(slice(0))


def columns_of(image, channel):
    """Image columns where a channel stands out."""
    others = image[..., [c for c in range(3) if c != channel]].max(axis=2).astype(int)
    return np.nonzero((image[..., channel].astype(int) - others > 60).any(axis=0))[0]


def test_x_runs_to_the_right_in_both_maps(voxels):
    for image in (map3d(voxels, size=(400, 300)), topview.labels(voxels, [], size=(400, 380))):
        assert columns_of(image, 0).mean() < columns_of(image, 2).mean() - 50


def test_z_runs_down_the_page():
    index = np.array([[0, 0, -5], [0, 0, 5]])
    colours = np.array([[220, 20, 20], [20, 20, 220]], dtype=np.uint8)
    voxels = Voxels(
        index=index, centres=index + 0.5, means=index + 0.5, counts=np.full(2, 9),
        colours=colours, cell_size=1.0,
    )  # fmt: skip
    image = topview.labels(voxels, [], size=(400, 380)).transpose(1, 0, 2)
    assert columns_of(image, 0).mean() < columns_of(image, 2).mean() - 50


def test_sizes_are_as_asked_and_nothing_is_drawn_without_cells(nothing):
    assert map3d(nothing, size=(320, 240)).shape == (240, 320, 3)
    assert topview.occupancy(nothing, size=(300, 280)).shape == (280, 300, 3)
    assert map3d(nothing, size=(320, 240)).std(axis=(0, 1)).max() == 0


def test_names_are_drawn(voxels):
    found = FoundObject(
        id=0, label="pine tree", probability=0.9, centre=np.array([5.0, 2, 0]),
        size=np.array([4.0, 4, 4]), num_voxels=8,
    )  # fmt: skip
    for draw in (lambda o: map3d(voxels, o, size=(400, 300)), lambda o: topview.labels(voxels, o)):
        assert (draw([found]) != draw([])).any()


def test_an_unknown_view_is_refused(voxels):
    with pytest.raises(InputError, match="'below', but one of default, top"):
        map3d(voxels, view="below")


def test_the_same_figure_is_the_same_bytes(voxels, tmp_path):
    for name in ("a.png", "b.png"):
        save_png(map3d(voxels, size=(320, 240)), tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_disparity_is_drawn_at_u_v(voxels):
    zeros = np.zeros(1, np.int32)
    matches = Matches(
        points_px=np.array([[80.0, 10.0]]), disparity_px=np.ones(1), sigma_px=np.ones(1),
        score=np.ones(1), index_left=zeros, index_right=zeros,
    )  # fmt: skip
    left = np.full((60, 100), 128, np.uint8)
    with_point = disparity(left, matches, size=(500, 400))
    without = disparity(left, matches.select(slice(0)), size=(500, 400))
    assert with_point.shape == without.shape == (400, 500, 3)
    assert (with_point != without).any()


def test_errors_stand_out_where_they_are():
    zeros = np.zeros(2, np.int32)
    matches = Matches(
        points_px=np.array([[20.0, 30.0], [80.0, 30.0]]), disparity_px=np.array([3.0, 9.0]),
        sigma_px=np.ones(2), score=np.ones(2), index_left=zeros, index_right=zeros,
    )  # fmt: skip
    left = np.full((60, 100), 128, np.uint8)
    right_everywhere = error_map(left, matches, np.where(np.arange(100) < 50, 3.0, 9.0) + left * 0)
    wrong_once = error_map(left, matches, np.full((60, 100), 3.0))
    assert right_everywhere.shape == wrong_once.shape
    assert (right_everywhere != wrong_once).any()
    unknown = error_map(left, matches, np.full((60, 100), np.nan))
    assert (unknown != wrong_once).any()


def test_a_single_place_and_no_cells_make_a_image(nothing):
    assert topview.path(np.eye(4)[None], nothing, size=(300, 280)).shape == (280, 300, 3)


def test_a_model_is_drawn_beside_what_was_measured():
    phases = np.linspace(-np.pi, np.pi, 91)
    narrow, wide = (np.exp(-((phases / spread) ** 2)) for spread in (0.3, 1.0))
    measured = np.random.default_rng(0).normal(0, 0.3, 500)
    image = mixture(phases, [[wide, narrow]], [measured], ["filters"])
    shifted = mixture(phases, [[wide, narrow]], [measured + 1], ["filters"])
    assert image.shape == shifted.shape == (420, 1300, 3)
    assert (image != shifted).any(axis=2).mean() > 0.01
    assert mixture(phases, [[wide]], [np.zeros(0)], ["nothing"]).shape == (420, 1300, 3)


def test_unknown_pixels_show_the_image():
    left = np.full((30, 40, 3), 120, np.uint8)
    found = np.full((30, 40), np.nan)
    found[:, :20] = np.linspace(0, 30, 20)
    image = dense(left, found)
    spread = image.max(axis=2).astype(int) - image.min(axis=2)
    strong = (spread > 80).mean(axis=0)
    assert strong[: image.shape[1] // 3].max() > 0.5
    middle = slice(image.shape[1] // 2, image.shape[1] * 4 // 5)
    assert strong[middle].max() < 0.2
    assert dense(left, np.full((30, 40), np.nan)).shape == image.shape
