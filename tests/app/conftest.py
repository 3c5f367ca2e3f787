"""A real browser, and recon's pages served to it."""

import base64
import os
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest

from recon.cli import main
from tests.conftest import figureless

ROOT = Path(__file__).parents[2]
PROGRAM = "import sys; sys.argv[0] = 'recon'; from recon.cli import entry; sys.exit(entry())"
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
TIMEOUT_S = 900
"""Far longer than anything takes, kernels that compile on a busy machine included."""


def missing_requirement():
    """Name what browser tests need and is not installed; None if everything is."""
    for module in ("playwright", "nicegui"):
        try:
            __import__(module)
        except ImportError:
            return module
    return None if chromium() else "chromium"


def chromium():
    names = ("chromium", "chromium-browser", "google-chrome")
    return next((path for name in names if (path := shutil.which(name))), None)


@pytest.fixture(scope="session")
def browser():
    lack = missing_requirement()
    if lack:
        if os.environ.get("RECON_REQUIRE_BROWSER") == "1":
            pytest.fail(f"{lack} is missing, but RECON_REQUIRE_BROWSER=1 asks for it")
        pytest.skip(f"{lack} is missing: pages are not tested")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        started = play.chromium.launch(
            executable_path=chromium(), args=FLAGS, timeout=1000.0 * TIMEOUT_S
        )
        yield started
        started.close()


@contextmanager
def served(*argv, folder, path=()):
    """Serve a page from a separate process and give its address; `path` extends PYTHONPATH."""
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(map(str, [ROOT, *path])),
        "TMPDIR": str(folder),
    }
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *argv, "--port", "0", "--no-browser"], cwd=folder,
        stdout=subprocess.PIPE, text=True, env=environment,
    )  # fmt: skip
    try:
        url = process.stdout.readline().strip()
        assert url.startswith("http://"), url
        # The socket already listens; requests are answered once the page is loaded.
        yield url
    finally:
        # A clean exit is not tested here, and takes long on a loaded machine.
        process.kill()
        process.wait()
        process.stdout.close()


def explored(folder):
    """Make a small run of the explorer."""
    argv = ["explore", "village", "--max-pairs", "6", "-o", str(folder), "-q"]
    with figureless():
        assert main(argv) == 0
    return folder


@pytest.fixture(scope="session")
def run(tmp_path_factory):
    return explored(tmp_path_factory.mktemp("app") / "walk")


def page_of(browser, url, first):
    """Open a page and wait for its image `first`; errors of the page are kept in `faults`."""
    context = browser.new_context(viewport={"width": 1280, "height": 800}, accept_downloads=True)
    page = context.new_page()
    page.faults = []
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.set_default_timeout(1000.0 * TIMEOUT_S)
    page.goto(url)
    wait_for_image(page, first)
    return page


def source(page, name):
    return page.get_by_test_id(name).locator("img").get_attribute("src")


def pixels(source):
    """Decode the image (H, W, 3) of a data URL."""
    data = base64.b64decode(source.partition(",")[2])
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)


def click(page, name, at):
    """Click a pixel (u, v) of an image as wide as its source."""
    box = page.get_by_test_id(name).bounding_box()
    width = pixels(source(page, name)).shape[1]
    u, v = (np.asarray(at) + 0.5) * box["width"] / width
    page.mouse.click(box["x"] + u, box["y"] + v)


def wait_for_image(page, name, before=None):
    """Wait until an image is drawn and differs from `before`; return its source."""
    page.wait_for_function(
        "([name, before]) => {"
        "const image = document.querySelector(`[data-testid=${name}] img`);"
        "return image && image.src.startsWith('data:') && image.complete && image.src !== before}",
        arg=[name, before],
    )
    return source(page, name)


def wait_for_text(page, name, text):
    """Wait until an element contains a text."""
    page.wait_for_function(
        "([name, text]) => document.querySelector(`[data-testid=${name}]`).innerText"
        ".includes(text)",
        arg=[name, text],
    )


def choose(page, name, option):
    page.get_by_test_id(name).click()
    page.get_by_role("option", name=option, exact=True).click()


def slide(page, name, value):
    page.get_by_test_id(name).fill(str(value))
