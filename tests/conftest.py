"""What the tests of every room share."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of recorded data, which is not part of the project."""
    default = Path(__file__).parents[2] / "shared" / "data"
    folder = Path(os.environ.get("RECON_DATA", default))
    if not folder.is_dir():
        message = f"recorded data is missing: {folder} (set RECON_DATA)"
        if os.environ.get("RECON_REQUIRE_DATA") == "1":
            pytest.fail(message)
        pytest.skip(message)
    return folder


@pytest.fixture(scope="module")
def without_figures() -> Iterator[None]:
    """Leave no figures in runs: they take most of a small run, and other tests draw them."""
    with pytest.MonkeyPatch.context() as patch:
        for kind in ("explore", "reconstruct", "merge"):
            patch.setattr(f"recon.runs.{kind}.write_run_figures", lambda *_: None)
        yield


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what is marked `slow`, unless marks are chosen: -m slow."""
    if config.getoption("markexpr"):
        return
    left_out = pytest.mark.skip(reason="slow; chosen by -m slow")
    for item in items:
        if item.get_closest_marker("slow"):
            item.add_marker(left_out)
