"""Fixtures and hooks shared by all tests."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

TESTS = Path(__file__).parent
SLOWEST = (
    "batch/test_determinism.py", "test_pages.py", "batch/test_chunks.py", "app/test_inspector.py",
    "test_readme.py", "app/test_simulator.py", "sequences/test_contradictions.py",
    "sequences/test_recorded_contradictions.py",
    "batch/test_batch.py", "runs/test_explore_run.py", "runs/test_ahead.py",
    "sequences/test_recorded.py", "test_examples.py", "runs/test_evaluate.py",
    "runs/test_localise.py", "exports/test_fuzz.py", "runs/test_recorded.py", "test_packaging.py",
)  # fmt: skip
"""Files that start first, so that no process is left alone with one of them at the end."""

# The same examples in every run, however slow the machine is, or while kernels compile; others with
# --hypothesis-profile fresh.
settings.register_profile("fresh", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("fixed", settings.get_profile("fresh"), derandomize=True)
settings.load_profile("fixed")


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of recorded data, which is not part of the project."""
    default = TESTS.parents[1] / "shared" / "data"
    folder = Path(os.environ.get("RECON_DATA", default))
    if not folder.is_dir():
        message = f"recorded data is missing: {folder} (set RECON_DATA)"
        if os.environ.get("RECON_REQUIRE_DATA") == "1":
            pytest.fail(message)
        pytest.skip(message)
    return folder


@contextmanager
def figureless() -> Iterator[None]:
    """Leave no figures in runs: they take most of a small run, and other tests draw them."""
    with pytest.MonkeyPatch.context() as patch:
        for kind in ("explore", "reconstruct", "merge"):
            patch.setattr(f"recon.runs.{kind}.draw_run_figures", lambda *_: None)
        yield


@pytest.fixture(scope="module")
def without_figures() -> Iterator[None]:
    """Make runs without figures in all tests of a file."""
    with figureless():
        yield


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put the slowest files first; leave out what is marked `slow`, unless marks are chosen."""
    items.sort(key=_place)
    if config.getoption("markexpr"):
        return
    left_out = pytest.mark.skip(reason="slow; chosen by -m slow")
    for item in items:
        if item.get_closest_marker("slow"):
            item.add_marker(left_out)


def _place(item: pytest.Item) -> int:
    """Rank an item by its file; all files but the slowest share the last rank."""
    file = item.path.relative_to(TESTS).as_posix()
    return SLOWEST.index(file) if file in SLOWEST else len(SLOWEST)
