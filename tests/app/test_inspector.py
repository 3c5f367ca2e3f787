"""The inspector in a real browser: everything that can be clicked, dragged and typed."""

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
    page_of,
    pixels,
    served,
    slide,
    source,
    wait_for_image,
    wait_for_text,
)


@pytest.fixture(scope="module")
def page(browser, run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("inspect")
    with served("inspect", str(run), folder=folder) as url:
        page = page_of(browser, url, "scene")
        page.url_of_server = url
        yield page
        assert page.faults == []


def test_all_elements_are_present_on_load(page):
    for name in (
        "scene", "colour-by", "threshold-count", "objects", "point-info", "trajectory-slider",
        "pair-left", "pair-disparity", "export", "shown-share", "message",
    ):  # fmt: skip
        assert page.get_by_test_id(name).count() == 1, name


def test_whole_map_is_shown_with_its_share(page):
    wait_for_text(page, "shown-share", "(100%)")
    number = re.search(r"of ([\d,]+) cells", page.get_by_test_id("shown-share").inner_text())
    assert int(number[1].replace(",", "")) > 100


def test_drag_rotates_and_wheel_zooms_in(page):
    before = source(page, "scene")
    box = page.get_by_test_id("scene").bounding_box()
    page.mouse.move(box["x"] + 300, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 380, box["y"] + 230, steps=3)
    turned = wait_for_image(page, "scene", before)
    page.mouse.up()
    page.mouse.wheel(0, -300)
    wait_for_image(page, "scene", turned)
    page.get_by_role("button", name="default").click()


def test_cells_are_coloured_by_a_column_with_a_colour_bar(page):
    before = source(page, "scene")
    choose(page, "colour-by", "count")
    wait_for_image(page, "scene", before)
    page.get_by_test_id("scene").locator("svg text", has_text="count").wait_for()
    choose(page, "colour-by", "colour")


def test_threshold_filters_cells(page):
    slide(page, "threshold-count", 9)
    wait_for_text(page, "shown-share", "filtered out")
    slide(page, "threshold-count", 1)
    wait_for_text(page, "shown-share", "(100%)")


def test_table_row_and_scene_object_select_each_other(page):
    table = page.get_by_test_id("objects")
    if table.locator("tbody tr").count() == 0:
        pytest.fail("no object was found")
    before = source(page, "scene")
    table.locator("tbody tr").first.click()
    selected = wait_for_image(page, "scene", before)
    table.locator("tbody tr").first.click()
    wait_for_image(page, "scene", selected)


def test_click_shows_the_values_of_the_cell(page):
    image = pixels(source(page, "scene"))
    # A click on the outermost rows may miss the image.
    inner = image[:-8].astype(int)
    v, u = np.nonzero(np.abs(inner - image[0, 0]).sum(axis=2) > 60)
    for at in ((u[0], v[0]), (u[-1], v[-1])):
        click(page, "scene", at)
        wait_for_text(page, "point-info", "count:")
    wait_for_text(page, "point-info", "from the last click")
    wait_for_text(page, "point-info", "world units")


def test_slice_is_one_cell_thick(page):
    choose(page, "slice", "y")
    wait_for_text(page, "shown-share", "filtered out")
    page.get_by_text(re.compile(r"y \[world units\] from [\d.]+ to [\d.]+")).wait_for()
    choose(page, "slice", "none")
    wait_for_text(page, "shown-share", "(100%)")


def test_keyboard_rotates_and_switches_to_the_top_view(page):
    before = source(page, "scene")
    scene = page.get_by_test_id("scene")
    scene.press("ArrowLeft")
    turned = wait_for_image(page, "scene", before)
    scene.press("5")
    wait_for_image(page, "scene", turned)
    page.get_by_role("button", name="default").click()


def test_slider_steps_through_the_pairs(page):
    wait_for_image(page, "pair-left")
    before = wait_for_image(page, "pair-disparity")
    slide(page, "trajectory-slider", 2)
    wait_for_image(page, "pair-disparity", before)
    page.get_by_text(re.compile(r"pair 2 \(0 to 5\): [\d,]+ matched points")).wait_for()
    for shown, said in (("every pixel", r"\d+% of the pixels"), ("features", "[\\d,]+ features")):
        before = source(page, "pair-disparity")
        choose(page, "pair-shown", shown)
        wait_for_image(page, "pair-disparity", before)
        page.get_by_text(re.compile(rf"pair 2 \(0 to 5\): .*{said}")).wait_for()


def test_export_contains_what_is_shown(page, tmp_path):
    slide(page, "threshold-count", 9)
    wait_for_text(page, "shown-share", "filtered out")
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
    wait_for_text(page, "shown-share", "(100%)")


def test_second_visitor_has_an_independent_view(page, browser):
    other = page_of(browser, page.url_of_server, "scene")
    slide(other, "threshold-count", 9)
    wait_for_text(other, "shown-share", "filtered out")
    assert "(100%)" in page.get_by_test_id("shown-share").inner_text()
    other.context.close()


@pytest.fixture(scope="module")
def copied(run, tmp_path_factory):
    """A copy of the run with its own scene file and a mesh, and beside it a large cloud."""
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
        wait_for_image(page, "scene-2")
        yield page
        assert page.faults == []


def test_two_scenes_side_by_side_rotate_together(both):
    wait_for_text(both, "shown-share", "160,000 of 160,000 points (100%)")
    choose(both, "layer-2", "mesh")
    wait_for_text(both, "shown-share-2", "4 of 4 vertices")
    box = both.get_by_test_id("scene").bounding_box()
    before = source(both, "scene-2")
    both.mouse.move(box["x"] + 100, box["y"] + 100)
    both.mouse.down()
    both.mouse.move(box["x"] + 160, box["y"] + 120, steps=3)
    wait_for_text(both, "shown-share", "50% of the 160,000 that pass, drawn at random")
    both.mouse.up()
    wait_for_text(both, "shown-share", "(100%)")
    wait_for_image(both, "scene-2", before)


def test_deleted_files_give_a_message_and_keep_the_image(both, copied):
    (copied / "mine.scene").unlink()
    slide(both, "trajectory-slider-2", 1)
    wait_for_text(both, "message-2", "no longer exists")
    shutil.rmtree(copied / "walk")
    slide(both, "trajectory-slider-2", 2)
    wait_for_text(both, "message-2", "settings.toml")
    assert source(both, "scene-2").startswith("data:")
