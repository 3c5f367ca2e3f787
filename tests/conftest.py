"""What the tests of every room share."""

import os
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


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what is marked `slow`, unless marks are chosen: -m slow."""
    if config.getoption("markexpr"):
        return
    left_out = pytest.mark.skip(reason="slow; chosen by -m slow")
    for item in items:
        if item.get_closest_marker("slow"):
            item.add_marker(left_out)
