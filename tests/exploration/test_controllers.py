"""Controllers by name, including plugins installed beside recon."""

import importlib
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from recon.errors import InputError
from recon.exploration import frontier, gains, paths, prospects, sides, thesis, tour, viewpoints
from recon.exploration.controllers import CONTROLLERS, make_controller

PLUGIN = Path(__file__).parents[2] / "docs" / "plugin"


@pytest.fixture
def plugged_in(tmp_path, monkeypatch):
    """Install the example package where only this test finds it."""
    # Building leaves files in the source folder, so a copy is built.
    source, target = shutil.copytree(PLUGIN, tmp_path / "source"), tmp_path / "installed"
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    pip = [sys.executable, "-m", "pip", "install", *options, "--target", target, source]
    subprocess.run(pip, check=True)
    monkeypatch.syspath_prepend(str(target))
    importlib.invalidate_caches()
    yield
    for name in [name for name in sys.modules if name.startswith("recon_example")]:
        del sys.modules[name]


@pytest.mark.parametrize("name", CONTROLLERS.names())
def test_every_controller_has_an_info_text(name):
    controller = make_controller(name)
    assert controller.info()
    assert "\n" not in controller.info()


def test_unknown_controller_is_rejected_with_the_known_ones():
    with pytest.raises(InputError, match=r"'fronteer'.*frontier, thesis.*nearest: frontier"):
        make_controller("fronteer")


def test_controller_of_the_example_package_explores(plugged_in, explore_discs):
    done = explore_discs([(20.0, 0.0, 4.0, 12.0)], controller="carousel")
    assert (done.stop_reason, done.message) == ("controller ended", "12 views on a circle")
    places = np.array([view.position for view in done.views])[1:]
    assert len(places) == 12
    assert np.allclose(np.hypot(places[:, 0], places[:, 2]), 8.0)


def test_plugin_that_does_not_load_is_rejected_by_name(tmp_path, monkeypatch):
    info = tmp_path / "broken-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Name: broken\nVersion: 1\n")
    (info / "entry_points.txt").write_text("[recon.controllers]\nbroken = nowhere:Nobody\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(InputError, match=r"'broken' .*nowhere:Nobody.* does not load"):
        make_controller("broken")


def test_controller_that_lacks_a_method_is_rejected_before_it_is_asked(monkeypatch):
    class Mute:
        def next_view(self, state):
            return None

        def info(self):
            return "says nothing in the end"

    monkeypatch.setattr(CONTROLLERS, "load", lambda name: Mute)
    with pytest.raises(InputError, match="controller 'mute' has no result, but an object with"):
        make_controller("mute")


@pytest.mark.parametrize(
    "module", [frontier, thesis, paths, prospects, viewpoints, gains, sides, tour]
)
def test_built_in_controllers_do_not_use_the_simulator(module):
    assert "simulator" not in Path(module.__file__).read_text()


class AskedTwice(frontier.FrontierController):
    """Asked again for every view, as where something is in the way."""

    def next_view(self, state):
        super().next_view(state)
        return super().next_view(state)


def test_looks_of_a_view_that_is_not_taken_do_not_count(explore_discs):
    discs = [(20.0, 5.0, 4.0, 12.0)]
    once, twice = (
        explore_discs(discs, led_by=led_by).views
        for led_by in (frontier.FrontierController(), AskedTwice())
    )
    assert len(once) == len(twice)
    assert all(np.array_equal(a.position, b.position) for a, b in zip(once, twice, strict=True))
