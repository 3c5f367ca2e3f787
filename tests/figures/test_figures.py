"""Figures: the right size, the right colours in the right places, the same bytes twice."""

from dataclasses import replace

import numpy as np
import pytest

from recon.errors import InputError
from recon.figures.canvas import SMALLEST_FONT, Sheet, Style, pixels, save
from recon.figures.confusion import confusion_matrix
from recon.figures.disparity import dense, disparity
from recon.figures.map3d import Standpoint, map3d, valued
from recon.figures.matching import Drawn, error_map
from recon.figures.mesh import mesh
from recon.figures.mixture import mixture
from recon.figures.occupancy import labels, occupancy
from recon.figures.overview import overview
from recon.figures.slices import slices
from recon.figures.trajectory import trajectory
from recon.records import Mesh, Voxels


def small(width=400, height=320, **style):
    return Sheet.of((width, height), Style(**style))


def columns_of(image, channel):
    """Find the image columns in which a colour channel dominates."""
    others = image[..., [c for c in range(3) if c != channel]].max(axis=2).astype(int)
    return np.nonzero((image[..., channel].astype(int) - others > 60).any(axis=0))[0]


def test_x_runs_to_the_right(voxels):
    for view in ("default", "front", "top"):
        image = pixels(map3d(voxels, standpoint=Standpoint(view=view), sheet=small()))
        assert columns_of(image, 0).mean() < columns_of(image, 2).mean() - 50
    image = pixels(map3d(voxels, standpoint=Standpoint(view="back"), sheet=small()))
    assert columns_of(image, 0).mean() > columns_of(image, 2).mean() + 50


def test_z_runs_down_the_floor():
    index = np.array([[0, 0, -5], [0, 0, 5]])
    voxels = Voxels(
        index=index, centres=index + 0.5, means=index + 0.5, counts=np.array([1, 900]),
        colours=np.zeros((2, 3), np.uint8), cell_size=1.0,
    )  # fmt: skip
    figure = occupancy(voxels, sheet=small())
    low, high = figure.axes[0].get_ylim()
    assert low > 5.5
    assert high < -4.5


def test_figures_have_the_requested_size_even_without_cells(no_voxels):
    image = pixels(map3d(no_voxels, sheet=small(320, 240, with_title=False)))
    assert image.shape == (240, 320, 3)
    assert image.std(axis=(0, 1)).max() == 0
    assert pixels(occupancy(no_voxels, sheet=small(300, 280))).shape == (280, 300, 3)
    assert pixels(labels(no_voxels, [], sheet=small(300, 280))).shape == (280, 300, 3)
    assert pixels(slices(no_voxels, sheet=small(300, 280))).shape == (280, 300, 3)
    for at_rest in (1, 3):
        poses = np.tile(np.eye(4), (at_rest, 1, 1))
        assert pixels(trajectory(poses, no_voxels, sheet=small())).shape == (320, 400, 3)


def test_floor_plans_have_tight_margins_unless_a_size_is_given(voxels, ball):
    height, width = pixels(labels(voxels, [ball])).shape[:2]
    assert width == pytest.approx(1000, abs=2)
    assert 250 < height < 700
    assert pixels(labels(voxels, [ball], sheet=small(500, 480))).shape == (480, 500, 3)


def test_titles_can_be_left_out(voxels):
    def texts(with_title):
        figure = occupancy(voxels, sheet=small(with_title=with_title))
        return figure.axes[0].get_title(loc="left")

    assert texts(with_title=True).startswith("Occupancy")
    assert texts(with_title=False) == ""


def test_transparent_background_has_zero_alpha(voxels, tmp_path):
    from matplotlib.image import imread

    corners = {}
    for background in ("white", "transparent"):
        path = tmp_path / f"{background}.png"
        save(map3d(voxels, sheet=small(background=background)), path)
        corners[background] = imread(path)[-1, 0, 3]
    assert corners == {"white": 1.0, "transparent": 0.0}


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_same_figure_gives_the_same_bytes(voxels, ball, tmp_path, ending):
    paths = [tmp_path / f"{name}.{ending}" for name in "ab"]
    for path in paths:
        save(labels(voxels, [ball], sheet=small()), path)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert paths[0].stat().st_size > 2000


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_names_in_any_script_are_drawn_without_a_warning(voxels, ball, tmp_path, ending):
    """Warnings are errors in tests."""
    named = replace(ball, label="名前")
    save(labels(voxels, [named], sheet=small()), tmp_path / f"labels.{ending}")
    pixels(labels(voxels, [named], sheet=small()))


def test_text_too_large_for_its_sheet_is_drawn_without_a_warning(voxels, ball, tmp_path):
    sheet = small(300, 200, font_size=72.0, dpi=600)
    save(labels(voxels, [ball], sheet=sheet), tmp_path / "labels.png")


def test_unknown_extension_is_rejected(voxels, tmp_path):
    with pytest.raises(InputError, match="'bmp' is not a format, but png, pdf, svg are"):
        save(occupancy(voxels, sheet=small()), tmp_path / "a.bmp")


def test_unknown_view_is_rejected():
    with pytest.raises(InputError, match="'below', but one of default, front"):
        Standpoint(view="below")


def test_colour_coded_values_have_a_colour_bar(voxels):
    figure = valued(voxels, np.arange(8.0), "metres", sheet=small())
    assert "metres" in [axes.get_ylabel() for axes in figure.axes]


def test_lengths_show_their_unit(voxels, ball):
    figure = labels(voxels, [ball], unit="m", sheet=small(900, 800))
    assert figure.axes[0].get_xlabel() == "x [m]"
    assert any(text.get_text().endswith(" m") for text in figure.axes[0].texts)


def test_labels_show_their_probability(voxels, ball):
    written = [text.get_text() for text in labels(voxels, [ball], sheet=small()).axes[0].texts]
    assert "pine tree 90%" in written
    assert "pine tree 90%" not in [
        text.get_text() for text in labels(voxels, [], sheet=small()).axes[0].texts
    ]


def test_font_size_scales_with_the_sheet_but_stays_legible():
    medium, large = Sheet.of((900, 900)), Sheet.of((2700, 2700))
    assert large.font_size == pytest.approx(3 * medium.font_size)
    assert Sheet.of((100, 100)).font_size == SMALLEST_FONT < medium.font_size
    assert Sheet.of((600, 600), Style(font_size=7.5)).font_size == 7.5


def test_overview_is_one_figure(voxels):
    drawn = []
    panels = [lambda sheet: drawn.append(sheet.size), lambda sheet: occupancy(voxels, sheet=sheet)]
    figure = overview(lambda sheet: map3d(voxels, sheet=sheet), panels, sheet=small(900, 600))
    (size,) = drawn
    assert size[0] < 450
    assert size[1] < 320
    assert len(figure.subfigs) == 2


def test_disparity_is_drawn_at_u_v():
    left = np.full((60, 100), 128, np.uint8)
    at = np.array([[80.0, 10.0]])
    with_point = pixels(disparity(left, at, np.ones(1), sheet=small()))
    without = pixels(disparity(left, at[:0], np.ones(0), sheet=small()))
    assert with_point.shape == without.shape == (320, 400, 3)
    assert (with_point != without).any()


def test_unknown_pixels_show_the_image():
    left = np.full((30, 40, 3), 120, np.uint8)
    found = np.full((30, 40), np.nan)
    found[:, :20] = np.linspace(0, 30, 20)
    image = pixels(dense(left, found, sheet=small(600, 400)))
    spread = image.max(axis=2).astype(int) - image.min(axis=2)
    strong = (spread > 80).mean(axis=0)
    assert strong[: image.shape[1] // 3].max() > 0.5
    middle = slice(image.shape[1] // 2, image.shape[1] * 4 // 5)
    assert strong[middle].max() < 0.2
    assert pixels(dense(left, np.full((30, 40), np.nan), sheet=small())).shape == (320, 400, 3)


def test_error_map_reports_the_share_of_bad_matches():
    found = Drawn(
        points_px=np.array([[20.0, 30.0], [80.0, 30.0]]), disparity_px=np.array([3.0, 9.0])
    )
    left = np.full((60, 100), 128, np.uint8)

    def title(truth):
        return error_map(left, found, truth, sheet=small(800, 400)).axes[1].get_title(loc="left")

    right = np.where(np.arange(100) < 50, 3.0, 9.0) + left * 0.0
    assert title(right) == "Error: 0.00% of 2 are over 1 px"
    assert title(np.full((60, 100), 3.0)) == "Error: 50.00% of 2 are over 1 px"
    assert title(np.full((60, 100), np.nan)) == "Error: 0.00% of 0 are over 1 px"


def test_confusion_matrix_counts_pairs_of_labels():
    figure = confusion_matrix(["a", "a", "b"], ["a", "b", "b"], sheet=small())
    written = sorted(text.get_text() for text in figure.axes[0].texts)
    assert written == ["0", "1", "1", "1"]


def test_mixture_is_drawn_over_the_measurements():
    phases = np.linspace(-np.pi, np.pi, 91)
    narrow, wide = (np.exp(-((phases / spread) ** 2)) for spread in (0.3, 1.0))
    measured = np.random.default_rng(0).normal(0, 0.3, 500)
    image = pixels(mixture(phases, [[wide, narrow]], [measured], ["filters"]))
    shifted = pixels(mixture(phases, [[wide, narrow]], [measured + 1], ["filters"]))
    assert image.shape == shifted.shape == (420, 1300, 3)
    assert (image != shifted).any(axis=2).mean() > 0.01
    empty = mixture(phases, [[wide]], [np.zeros(0)], ["nothing"])
    assert pixels(empty).shape == (420, 1300, 3)


def test_mesh_is_seen_from_its_cameras():
    vertices = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0.0]])
    colours = np.array([[200, 20, 20], [20, 20, 200], [20, 20, 200], [200, 20, 20]], np.uint8)
    surface = Mesh(
        vertices=vertices, triangles=np.array([[0, 1, 2], [0, 2, 3]], np.int32), colours=colours
    )
    for side, sign in ((5.0, 1), (-5.0, -1)):
        image = pixels(mesh(surface, np.array([[0.0, 0.0, side]]), sheet=small(600, 300)))
        red, blue = (columns_of(image[:, :300], channel).mean() for channel in (0, 2))
        assert sign * (blue - red) > 30


def test_mesh_has_a_grid_and_other_views(tmp_path):
    vertices = np.array([[-1, 0, 0], [1, 0, 0], [1, 2, 0], [-1, 2, 0.0]])
    surface = Mesh(vertices=vertices, triangles=np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    cameras = np.array([[0.0, 1.0, 5.0]])
    shares = {}
    for view in ("default", "top"):
        figure = mesh(surface, cameras, standpoint=Standpoint(view=view, unit="m"), sheet=small())
        assert any("grid" in text.get_text() for text in figure.axes[0].texts)
        shares[view] = (pixels(figure).max(axis=2) < 215).mean()
    # Seen from the top, an upright square is a line.
    assert shares["top"] < 0.5 * shares["default"]
