"""Figures 22 to 24: the simulator in a browser, as screenshots."""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Any

from reproduction.entry import Absent, Entry, Result

PROGRAM = "import sys; sys.argv[0] = 'recon'; from recon.cli import entry; sys.exit(entry())"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
TIMEOUT_MS = 120_000
WINDOW = {"width": 1280, "height": 860}
PLACE = {"x": -6, "z": 34, "target-x": 4, "target-z": -8, "target-y": 6}
"""A place from which the cottage and trees of both kinds are seen."""
IS_DRAWN = """([name, before]) => {
  const image = document.querySelector(`[data-testid=${name}] img`);
  return image && image.src.startsWith('data:') && image.complete && image.src !== before; }"""


def entries() -> Iterator[Entry]:
    """List the entries of this part."""
    yield Entry(
        name="figure 22", title="The simulator", make=partial(_shot, "figure_22"),
        thesis="Four panes: left eye, right eye, top view and front view, and dialogs below them.",
        difference="The same panes in a browser; the dialogs stand beside them.",
    )  # fmt: skip
    yield Entry(
        name="figure 23", title="Feature points and their channels",
        make=partial(_shot, "figure_23"),
        thesis="Points are black on the left view, and in the colours of channel 3, disparity, on "
        "the right one; a click shows all channels of a point.",
        difference="The channel colours the points of both eyes, with a scale; the point that was "
        "clicked is marked in both.",
    )  # fmt: skip
    yield Entry(
        name="figure 24", title="The top view with camera and target",
        make=partial(_shot, "figure_24"),
        thesis="Camera and target are dragged in the top and front view.",
        difference="The same; the field of view is drawn, too.",
    )  # fmt: skip


def _shot(name: str) -> Result:
    return Result(images=(_shots() / f"{name}.png",))


@cache
def _shots() -> Path:
    """Make a folder with all screenshots."""
    folder = Path(tempfile.mkdtemp(prefix="recon-reproduce-"))
    with _page() as page:
        for name, value in PLACE.items():
            field = page.get_by_test_id(f"field-{name}")
            field.fill(str(value))
            field.press("Enter")
        page.wait_for_function("() => document.querySelector('[data-testid=field-z]').value == 34")
        page.wait_for_load_state("networkidle")
        page.screenshot(path=folder / "figure_22.png")
        page.get_by_test_id("pane-top").screenshot(path=folder / "figure_24.png")
        _show_disparity(page)
        _screenshot_of_eyes(page, folder / "figure_23.png")
    return folder


def _show_disparity(page: Any) -> None:
    page.get_by_test_id("channel").click()
    page.get_by_role("option", name="disparity", exact=True).click()
    page.get_by_test_id("pane-left").locator("svg text", has_text="disparity").wait_for()
    box = page.get_by_test_id("pane-left").bounding_box()
    for share in range(30, 70, 2):
        page.mouse.click(box["x"] + share / 100 * box["width"], box["y"] + 0.45 * box["height"])
        page.wait_for_timeout(300)
        if page.get_by_test_id("mark-right").count():
            return


def _screenshot_of_eyes(page: Any, path: Path) -> None:
    left, right = (page.get_by_test_id(f"pane-{side}").bounding_box() for side in ("left", "right"))
    clip = {
        "x": left["x"], "y": left["y"], "width": right["x"] + right["width"] - left["x"],
        "height": left["height"],
    }  # fmt: skip
    page.screenshot(path=path, clip=clip)


@contextmanager
def _page() -> Iterator[Any]:
    """Open the simulator's page in a browser.

    Raises
    ------
    Absent
        If there is no browser, or no driver for it.
    """
    browser = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if browser is None:
        raise Absent("no screenshots: there is no chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError as error:
        raise Absent("no screenshots: playwright is not installed") from error
    with _server() as url, sync_playwright() as play:
        started = play.chromium.launch(executable_path=browser, args=FLAGS)
        page = started.new_page(viewport=WINDOW)
        page.set_default_timeout(TIMEOUT_MS)
        page.goto(url)
        for name in ("pane-left", "pane-right", "pane-top", "pane-front"):
            page.wait_for_function(IS_DRAWN, arg=[name, None])
        page.get_by_test_id("theme").click()
        yield page
        started.close()


@contextmanager
def _server() -> Iterator[str]:
    root = str(Path(__file__).parents[2])
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, "simulate", "village", "--port", "0", "--no-browser"],
        stdout=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": root},
    )  # fmt: skip
    assert process.stdout is not None
    try:
        url = process.stdout.readline().strip()
        if not url:
            raise Absent("no screenshots: recon's extra [app] is not installed")
        yield url
    finally:
        process.terminate()
        process.wait()
        process.stdout.close()
