"""The inspector in a real browser: all that can be clicked, dragged and typed, by what it shows."""

import json
import re
import shutil

import numpy as np
import pytest

from recon.exports.formats import read, write
from recon.records import Mesh, PointCloud
from recon.world.library import find_scene
from tests.app.conftest import choose, drawn, page_of, says, served, slide, source


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
    drawn(page, "scene", before)
    table.locator("tbody tr").first.click()


def test_a_click_tells_what_lies_there(page):
    info = page.get_by_test_id("point-info")
    for box in [name.bounding_box() for name in page.get_by_test_id("scene").locator("text").all()]:
        for below in (25, 40, 55):
            page.mouse.click(box["x"] + box["width"] / 2, box["y"] + below)
            page.wait_for_timeout(300)
            if "from the last click" in info.inner_text():
                assert "count:" in info.inner_text()
                assert "world units" in info.inner_text()
                return
    raise AssertionError("no cell was hit twice")


def test_a_slice_is_a_cell_thick(page):
    choose(page, "slice", "y")
    says(page, "shown-share", "filtered out")
    page.get_by_text(re.compile(r"y \[world units\] from [\d.]+ to [\d.]+")).wait_for()
    choose(page, "slice", "none")
    says(page, "shown-share", "(100%)")


def test_the_keyboard_turns_and_shows_from_the_top(page):
    before = source(page, "scene")
    page.get_by_test_id("scene").focus()
    page.keyboard.press("ArrowLeft")
    turned = drawn(page, "scene", before)
    page.keyboard.press("5")
    drawn(page, "scene", turned)
    page.get_by_role("button", name="default").click()


def test_the_slider_shows_the_pairs(page):
    drawn(page, "pair-left")
    before = drawn(page, "pair-disparity")
    slide(page, "trajectory-slider", 2)
    drawn(page, "pair-disparity", before)
    page.get_by_text(re.compile(r"pair 2 of 6: [\d,]+ matched points")).wait_for()
    for shown, said in (("every pixel", r"\d+% of the pixels"), ("features", "[\\d,]+ features")):
        before = source(page, "pair-disparity")
        choose(page, "pair-shown", shown)
        drawn(page, "pair-disparity", before)
        page.get_by_text(re.compile(f"pair 2 of 6: .*{said}")).wait_for()


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


def test_a_cloud_and_a_mesh_stand_side_by_side(browser, tmp_path):
    rng = np.random.default_rng(0)
    points = rng.random((400_000, 3)) * 10.0
    colours = rng.integers(0, 255, (400_000, 3)).astype(np.uint8)
    write(PointCloud(points=points, colours=colours), tmp_path / "cloud.ply")
    corners = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], np.int32)
    write(Mesh(vertices=corners, triangles=faces), tmp_path / "mesh.ply")
    with served("inspect", "cloud.ply", "mesh.ply", folder=tmp_path) as url:
        page = page_of(browser, url, "scene")
        drawn(page, "scene-2")
        says(page, "shown-share", "400,000 of 400,000 points (100%)")
        box = page.get_by_test_id("scene").bounding_box()
        before = source(page, "scene-2")
        page.mouse.move(box["x"] + 100, box["y"] + 100)
        page.mouse.down()
        page.mouse.move(box["x"] + 160, box["y"] + 120, steps=3)
        says(page, "shown-share", "20% of the 400,000 that pass, drawn at random")
        page.mouse.up()
        says(page, "shown-share", "(100%)")
        drawn(page, "scene-2", before)
        assert page.faults == []
        page.context.close()


def test_what_is_gone_is_a_message_and_what_was_shown_stays(browser, run, tmp_path):
    copy = shutil.copytree(run, tmp_path / "walk")
    with (copy / "settings.toml").open("a") as settings:
        settings.write("\n[gone]\nname = 1\n")
    scene = tmp_path / "mine.scene"
    shutil.copy(find_scene("village"), scene)
    scene.write_text(scene.read_text() + "\n")
    manifest = json.loads((copy / "manifest.json").read_text())
    manifest["input_paths"] = [str(scene)]
    (copy / "manifest.json").write_text(json.dumps(manifest))
    with served("inspect", "walk", folder=tmp_path) as url:
        scene.unlink()
        page = page_of(browser, url, "scene")
        says(page, "message", "no longer exists")
        shutil.rmtree(copy)
        slide(page, "trajectory-slider", 1)
        says(page, "message", "settings.toml")
        assert source(page, "scene").startswith("data:")
        says(page, "shown-share", "(100%)")
        assert page.faults == []
        page.context.close()
