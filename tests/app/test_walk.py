"""An exploration of a visitor: only a controller that does not answer is abandoned."""

from types import SimpleNamespace

import pytest

from recon.app import walk
from recon.app.walk import PATIENCE_S, Walk
from recon.settings import Settings
from recon.world.library import find_scene


class Clock:
    """Time that passes only when told."""

    def __init__(self):
        self.now = 1000.0

    def monotonic(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(walk, "time", clock)
    return clock


@pytest.fixture
def stopped(clock):
    """A walk that is told to stop while it compiles what plans its way."""
    walk = Walk(find_scene("village"), Settings())
    walk._thread = SimpleNamespace(ident=1)
    for stage in ("plan", "compiling"):
        walk._on_stage(stage)
    walk.stop()
    yield walk
    walk.discard()


def test_controller_that_compiles_for_long_is_not_abandoned(clock, stopped):
    clock.now += 5.0 * PATIENCE_S
    stopped.check()
    stopped._on_stage("plan")
    stopped.check()
    clock.now += 0.9 * PATIENCE_S
    stopped.check()
    assert stopped.state == "stopping"


def test_controller_that_does_not_answer_is_abandoned(clock, stopped):
    stopped._on_stage("plan")
    clock.now += 1.1 * PATIENCE_S
    stopped.check()
    assert (stopped.state, "abandoned" in stopped.error) == ("failed", True)
