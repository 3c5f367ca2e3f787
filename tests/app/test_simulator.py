"""The simulator in a real browser: moving cameras, points, frames and an exploration."""

import http.client
import json
import urllib.parse
import zipfile

import numpy as np
import pytest

from recon.app.image_panes import PLAIN_COLOUR
from recon.manifest import read_manifest
from tests.app.conftest import (
    TIMEOUT_S,
    choose,
    click,
    page_of,
    pixels,
    served,
    source,
    wait_for_image,
    wait_for_text,
)

PANES = ("pane-left", "pane-right", "pane-top", "pane-front")


FAULTY = """
import time

class Raises:
    def next_view(self, state):
        raise RuntimeError("no idea where to go")
    def info(self):
        return "raises"
    def result(self):
        return ""

class Hangs(Raises):
    def next_view(self, state):
        time.sleep(1e6)
"""
ENTRIES = "[recon.controllers]\nraises = naughty:Raises\nhangs = naughty:Hangs\n"


def write_faulty_controllers(folder):
    """Install a package with controllers that raise or hang."""
    (folder / "naughty.py").write_text(FAULTY)
    about = folder / "naughty-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: naughty\nVersion: 1\n")
    (about / "entry_points.txt").write_text(ENTRIES)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("simulate")


@pytest.fixture(scope="module")
def page(browser, folder, tmp_path_factory):
    plugins = tmp_path_factory.mktemp("plugins")
    write_faulty_controllers(plugins)
    with served("simulate", "village", folder=folder, path=[plugins]) as url:
        page = page_of(browser, url, "pane-left")
        for name in PANES:
            wait_for_image(page, name)
        page.url_of_server = url
        yield page
        assert page.faults == []


def value(page, name):
    return float(page.get_by_test_id(f"field-{name}").input_value())


def enter(page, name, text):
    page.get_by_test_id(f"field-{name}").fill(text)
    page.get_by_test_id(f"field-{name}").press("Enter")


def drag_and_hold(page, pane, symbol, right, down):
    """Drag a symbol without releasing it; return the position of the mouse."""
    box = page.get_by_test_id(pane).get_by_test_id(symbol).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right, y + down, steps=3)
    return x + right, y + down


def drag(page, pane, symbol, right, down):
    x, y = drag_and_hold(page, pane, symbol, right, down)
    # The next drag starts from wherever the symbol ends up.
    page.wait_for_function(
        "([pane, symbol, x, y]) => { const box = document.querySelector("
        "`[data-testid=${pane}] [data-testid=${symbol}]`).getBoundingClientRect();"
        "return Math.hypot(box.x + box.width / 2 - x, box.y + box.height / 2 - y) < 3 }",
        arg=[pane, symbol, x, y],
    )
    page.mouse.up()


def test_all_elements_are_present_on_load(page):
    fields = [
        "focal-length", "fov", "baseline", "near", "far", "x", "y", "z", "target-x", "target-y",
        "target-z",
    ]  # fmt: skip
    others = [
        "toggle-features", "channel", "point-info", "export-frame", "controller", "run", "step",
        "pause", "stop", "controller-info", "controller-result", "objects", "message",
    ]  # fmt: skip
    for name in [*PANES, *[f"field-{field}" for field in fields], *others]:
        assert page.get_by_test_id(name).count() == 1, name
    for name in ("camera-symbol", "target-symbol"):
        assert page.get_by_test_id(name).count() == 2, name


def test_dragging_the_camera_updates_fields_and_both_images(page):
    before = [source(page, name) for name in PANES[:2]]
    drag(page, "pane-top", "camera-symbol", 30, 40)
    for name, old in zip(PANES[:2], before, strict=True):
        wait_for_image(page, name, old)
    page.wait_for_function("() => document.querySelector('[data-testid=field-x]').value > 5")
    assert value(page, "z") > 5
    assert value(page, "y") == 5
    drag(page, "pane-front", "target-symbol", 20, -20)
    page.wait_for_function("() => document.querySelector('[data-testid=field-target-y]').value > 6")
    assert value(page, "target-x") > 2


def test_focal_length_and_field_of_view_are_coupled(page):
    before = source(page, "pane-left")
    enter(page, "focal-length", "0.2")
    wait_for_image(page, "pane-left", before)
    wanted = np.degrees(2 * np.arctan(np.tan(np.radians(40)) * 0.1 / 0.2))
    page.wait_for_function("() => document.querySelector('[data-testid=field-fov]').value < 60")
    assert value(page, "fov") == pytest.approx(wanted, abs=1e-3)
    enter(page, "fov", "80")
    page.wait_for_function(
        "() => document.querySelector('[data-testid=field-focal-length]').value < 0.15"
    )
    assert value(page, "focal-length") == pytest.approx(0.1, abs=1e-4)


def test_invalid_values_are_reported_and_change_nothing(page):
    for name, text, said in (
        ("focal-length", "0", "focal_length"), ("near", "200", "near"), ("x", "1000", "the world"),
        ("fov", "190", "fov_deg"),
    ):  # fmt: skip
        before = value(page, name)
        enter(page, name, text)
        wait_for_text(page, "message", said)
        page.wait_for_function(
            "([name, value]) => Number(document.querySelector(`[data-testid=field-${name}]`).value)"
            " === value",
            arg=[name, before],
        )


def test_points_are_coloured_and_a_click_marks_the_match(page):
    # A tree of the village fills the images.
    for name, number in (("target-x", -10), ("target-z", -5), ("target-y", 6), ("x", 0), ("z", 8)):
        enter(page, name, str(number))
    page.wait_for_function("() => document.querySelector('[data-testid=field-z]').value == 8")
    page.get_by_test_id("toggle-features").click()
    dotted = source(page, "pane-left")
    # Views of earlier field values may arrive first: they have no dots.
    while not (dots := (pixels(dotted) == PLAIN_COLOUR).all(axis=2)).any():
        dotted = wait_for_image(page, "pane-left", dotted)
    choose(page, "channel", "disparity")
    wait_for_image(page, "pane-left", dotted)
    page.get_by_test_id("pane-left").locator("svg text", has_text="disparity").wait_for()
    v, u = np.nonzero(dots)
    click(page, "pane-left", (u[0], v[0]))
    wait_for_text(page, "point-info", "disparity")
    info = page.get_by_test_id("point-info")
    for channel in ("x:", "depth:", "sigma:", "orientation:", "score:", "label:"):
        assert channel in info.inner_text()
    for side in ("left", "right"):
        assert page.get_by_test_id(f"mark-{side}").count() == 1
    page.get_by_test_id("toggle-features").click()


def test_frame_is_exported(page, folder, tmp_path):
    with page.expect_download() as download:
        page.get_by_test_id("export-frame").click()
    download.value.save_as(tmp_path / "frame.zip")
    with zipfile.ZipFile(tmp_path / "frame.zip") as archive:
        assert sorted(archive.namelist()) == ["frame.json", "left.png", "right.png"]
        about = json.loads(archive.read("frame.json"))
    assert about["camera"]["x"] == pytest.approx(value(page, "x"), abs=1e-5)
    assert (folder / "frames" / "village-001" / "left.png").stat().st_size > 1000


def test_exploration_is_controlled_survives_a_reload_and_is_saved(page, folder):
    wait_for_text(page, "controller-info", " ")
    page.get_by_test_id("stop").click()
    wait_for_text(page, "message", "no run is in progress")
    page.get_by_test_id("step").click()
    wait_for_text(page, "controller-result", "1 pairs")
    page.get_by_test_id("step").click()
    wait_for_text(page, "controller-result", "paused: 2 pairs")
    page.get_by_test_id("run").click()
    wait_for_text(page, "controller-result", "running")
    page.get_by_test_id("run").click()
    wait_for_text(page, "message", "it is already running")
    page.reload()
    wait_for_image(page, "pane-left")
    wait_for_text(page, "controller-result", " pairs")
    page.get_by_test_id("pause").click()
    page.get_by_test_id("stop").click()
    wait_for_text(page, "controller-result", "done")
    page.get_by_test_id("run-name").fill("../elsewhere")
    page.get_by_test_id("save-run").click()
    wait_for_text(page, "message", "without slashes")
    page.get_by_test_id("run-name").fill("mine")
    page.get_by_test_id("save-run").click()
    wait_for_text(page, "message", "run written to runs/mine")
    assert read_manifest(folder / "runs" / "mine")["command"] == "explore"


def test_right_click_exports_a_frame(page):
    page.get_by_test_id("pane-right").click(button="right")
    with page.expect_download() as download:
        page.get_by_role("menuitem").or_(page.locator(".q-menu .q-item")).first.click()
    assert download.value.suggested_filename.startswith("village-")
    wait_for_text(page, "message", "frame written to")


def select_and_press(page, controller, *buttons):
    choose(page, "controller", controller)
    for button in buttons:
        page.get_by_test_id(button).click()


def test_exception_in_a_controller_is_shown(page):
    select_and_press(page, "raises", "run")
    wait_for_text(page, "controller-result", "controller failed")
    wait_for_text(page, "controller-result", "no idea where to go")


def test_controller_that_never_returns_is_abandoned(page):
    select_and_press(page, "hangs", "run")
    wait_for_text(page, "controller-result", "plan")
    page.get_by_test_id("stop").click()
    # Meanwhile the page responds, and rejects invalid input.
    kept = value(page, "target-y")
    drag_and_hold(page, "pane-front", "target-symbol", 0, -100)
    wait_for_text(page, "message", "the world ends there")
    page.mouse.up()
    assert value(page, "target-y") == kept
    wait_for_text(page, "controller-result", "abandoned")
    select_and_press(page, "frontier", "step")
    wait_for_text(page, "controller-result", "paused: 1 pairs")
    page.get_by_test_id("stop").click()
    wait_for_text(page, "controller-result", "done")


@pytest.mark.parametrize(
    ("host", "origin", "status"),
    [("evil.example", None, 403), (None, "http://evil.example", 403), (None, None, 101)],
)
def test_foreign_page_cannot_open_a_socket(page, host, origin, status):
    own = urllib.parse.urlsplit(page.url_of_server).netloc
    connection = http.client.HTTPConnection(own, timeout=TIMEOUT_S)
    headers = {
        "Host": host or own, "Origin": origin or f"http://{host or own}", "Upgrade": "websocket",
        "Connection": "Upgrade", "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
        "Sec-WebSocket-Version": "13",
    }  # fmt: skip
    path = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"
    connection.request("GET", path, headers=headers)
    assert connection.getresponse().status == status
    connection.close()


def test_second_visitor_has_independent_cameras(page, browser):
    other = page_of(browser, page.url_of_server, "pane-left")
    assert value(other, "x") == 0
    enter(other, "x", "7")
    other.wait_for_function("() => document.querySelector('[data-testid=field-x]').value == 7")
    assert value(page, "x") != 7
    other.context.close()


def test_settings_are_shown_and_edited(page):
    text = page.get_by_test_id("settings")
    assert "cell_size = 1.0" in text.input_value()
    text.fill("[map]\ncell_size = 2.0\n")
    page.get_by_test_id("settings-apply").click()
    # Wait for the reply with all settings: it would overwrite anything typed before it arrives.
    page.wait_for_function(
        "() => ['cell_size = 2.0', '[render]'].every(words => "
        "document.querySelector('[data-testid=settings]').value.includes(words))"
    )
    text.fill("[map]\ncell_siz = 2.0\n")
    page.get_by_test_id("settings-apply").click()
    wait_for_text(page, "message", "nearest known name is map.cell_size")
    assert "cell_siz = 2.0" in text.input_value()
