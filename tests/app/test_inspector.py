"""The inspector in a real browser: all that can be clicked, dragged and typed, by what it shows."""

import json
import re
import shutil

import numpy as np
import pytest

from recon.exports.formats import read, write
from recon.records import Mesh, PointCloud
from recon.world.library import find_scene
from tests.app.conftest import (
    choose,
    click,
    drawn,
    page_of,
    pixels,
    says,
    served,
    slide,
    source,
)


@pytest.fixture(scope="module")
def page(browser, run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("inspect")
    with served("inspect", str(run), folder=folder) as url:
        page = page_of(browser, url, "scene")
        page.url_of_server = url
        yield page
        assert page.faults == []


def test_everything_is_in_the_page_from_the_start(page):
    for name in (
        "scene", "colour-by", "threshold-count", "objects", "point-info", "trajectory-slider",
        "pair-left", "pair-disparity", "export", "shown-share", "message",
    ):  # fmt: skip
        assert page.get_by_test_id(name).count() == 1, name


def test_the_whole_map_is_shown_and_says_so(page):
    says(page, "shown-share", "(100%)")
    number = re.search(r"of ([\d,]+) cells", page.get_by_test_id("shown-share").inner_text())
    assert int(number[1].replace(",", "")) > 100


def test_a_drag_turns_and_a_wheel_comes_nearer(page):
    before = source(page, "scene")
    box = page.get_by_test_id("scene").bounding_box()
    page.mouse.move(box["x"] + 300, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 380, box["y"] + 230, steps=3)
    turned = drawn(page, "scene", before)
    page.mouse.up()
    page.mouse.wheel(0, -300)
    drawn(page, "scene", turned)
    page.get_by_role("button", name="default").click()


def test_cells_are_coloured_by_a_column_with_its_scale(page):
    before = source(page, "scene")
    choose(page, "colour-by", "count")
    drawn(page, "scene", before)
    page.get_by_test_id("scene").locator("svg text", has_text="count").wait_for()
    choose(page, "colour-by", "colour")


def test_a_threshold_leaves_cells_out(page):
    slide(page, "threshold-count", 9)
    says(page, "shown-share", "filtered out")
    slide(page, "threshold-count", 1)
    says(page, "shown-share", "(100%)")


def test_a_row_selects_in_the_scene_and_a_click_selects_the_row(page):
    table = page.get_by_test_id("objects")
    if table.locator("tbody tr").count() == 0:
        pytest.fail("no object was found")
    before = source(page, "scene")
    table.locator("tbody tr").first.click()
    selected = drawn(page, "scene", before)
    table.locator("tbody tr").first.click()
    drawn(page, "scene", selected)


def test_a_click_tells_what_lies_there(page):
    image = pixels(source(page, "scene"))
    # A click on the outermost rows may miss the image.
    inner = image[:-8].astype(int)
    v, u = np.nonzero(np.abs(inner - image[0, 0]).sum(axis=2) > 60)
    for at in ((u[0], v[0]), (u[-1], v[-1])):
        click(page, "scene", at)
        says(page, "point-info", "count:")
    says(page, "point-info", "from the last click")
    says(page, "point-info", "world units")


def test_a_slice_is_a_cell_thick(page):
    choose(page, "slice", "y")
    says(page, "shown-share", "filtered out")
    page.get_by_text(re.compile(r"y \[world units\] from [\d.]+ to [\d.]+")).wait_for()
    choose(page, "slice", "none")
    says(page, "shown-share", "(100%)")


def test_the_keyboard_turns_and_shows_from_the_top(page):
    before = source(page, "scene")
    scene = page.get_by_test_id("scene")
    scene.press("ArrowLeft")
    turned = drawn(page, "scene", before)
    scene.press("5")
    drawn(page, "scene", turned)
    page.get_by_role("button", name="default").click()


def test_the_slider_shows_the_pairs(page):
    drawn(page, "pair-left")
    before = drawn(page, "pair-disparity")
    slide(page, "trajectory-slider", 2)
    drawn(page, "pair-disparity", before)
    page.get_by_text(re.compile(r"pair 2 \(0 to 5\): [\d,]+ matched points")).wait_for()
    for shown, said in (("every pixel", r"\d+% of the pixels"), ("features", "[\\d,]+ features")):
        before = source(page, "pair-disparity")
        choose(page, "pair-shown", shown)
        drawn(page, "pair-disparity", before)
        page.get_by_text(re.compile(rf"pair 2 \(0 to 5\): .*{said}")).wait_for()


def test_what_is_shown_is_exported(page, tmp_path):
    slide(page, "threshold-count", 9)
    says(page, "shown-share", "filtered out")
    shown = re.search(r"shows ([\d,]+) of", page.get_by_test_id("shown-share").inner_text())
    with page.expect_download() as download:
        page.get_by_test_id("export").click()
    path = tmp_path / download.value.suggested_filename
    download.value.save_as(path)
    voxels = read(path)
    assert path.name == "walk.ply"
    assert len(voxels) == int(shown[1].replace(",", ""))
    assert voxels.counts.min() >= 9
    slide(page, "threshold-count", 1)


def test_a_second_visitor_looks_for_himself(page, browser):
    other = page_of(browser, page.url_of_server, "scene")
    slide(other, "threshold-count", 9)
    says(other, "shown-share", "filtered out")
    assert "(100%)" in page.get_by_test_id("shown-share").inner_text()
    other.context.close()


@pytest.fixture(scope="module")
def copied(run, tmp_path_factory):
    """A copy of the run, of a scene of its own, with a mesh; beside it a large cloud."""
    folder = tmp_path_factory.mktemp("beside")
    copy = shutil.copytree(run, folder / "walk")
    with (copy / "settings.toml").open("a") as settings:
        settings.write("\n[gone]\nname = 1\n")
    scene = folder / "mine.scene"
    scene.write_text(find_scene("village").read_text() + "\n")
    manifest = json.loads((copy / "manifest.json").read_text())
    manifest["input_paths"] = [str(scene)]
    (copy / "manifest.json").write_text(json.dumps(manifest))
    corners = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], np.int32)
    write(Mesh(vertices=corners, triangles=faces), copy / "mesh.ply")
    rng = np.random.default_rng(0)
    colours = rng.integers(0, 255, (160_000, 3)).astype(np.uint8)
    write(PointCloud(points=rng.random((160_000, 3)), colours=colours), folder / "cloud.ply")
    return folder


@pytest.fixture(scope="module")
def both(browser, copied):
    with served("inspect", "cloud.ply", "walk", folder=copied) as url:
        page = page_of(browser, url, "scene")
        drawn(page, "scene-2")
        yield page
        assert page.faults == []


def test_two_stand_side_by_side_and_turn_together(both):
    says(both, "shown-share", "160,000 of 160,000 points (100%)")
    choose(both, "layer-2", "mesh")
    says(both, "shown-share-2", "4 of 4 vertices")
    box = both.get_by_test_id("scene").bounding_box()
    before = source(both, "scene-2")
    both.mouse.move(box["x"] + 100, box["y"] + 100)
    both.mouse.down()
    both.mouse.move(box["x"] + 160, box["y"] + 120, steps=3)
    says(both, "shown-share", "50% of the 160,000 that pass, drawn at random")
    both.mouse.up()
    says(both, "shown-share", "(100%)")
    drawn(both, "scene-2", before)


def test_what_is_gone_is_a_message_and_what_was_shown_stays(both, copied):
    (copied / "mine.scene").unlink()
    slide(both, "trajectory-slider-2", 1)
    says(both, "message-2", "no longer exists")
    shutil.rmtree(copied / "walk")
    slide(both, "trajectory-slider-2", 2)
    says(both, "message-2", "settings.toml")
    assert source(both, "scene-2").startswith("data:")
