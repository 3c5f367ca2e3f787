"""The pairs of a run in the inspector: what is said belongs to the pair that is shown."""

from unittest.mock import MagicMock

import numpy as np
import pytest

from recon.app import pair_viewer
from recon.app.pairs import SeenPair


@pytest.fixture
def viewer(monkeypatch):
    """A viewer of three pairs without a page."""
    for name in ("nicegui", "note", "slider", "chooser", "testid", "Painter", "Pairs"):
        monkeypatch.setattr(pair_viewer, name, MagicMock())
    exhibit = MagicMock(trajectory=range(3))
    viewer = pair_viewer.PairViewer(exhibit, "", MagicMock(), MagicMock())
    viewer.pairs.take = lambda number, shown: SeenPair(
        left=np.zeros((4, 6, 3), np.uint8), points_px=np.zeros((number, 2)),
        values=np.ones(number), label="disparity [px]",
    )  # fmt: skip
    return viewer


def test_pair_that_arrives_after_another_was_chosen_keeps_its_number(viewer):
    viewer._choose(1)
    taken = viewer._take()
    viewer._choose(2)
    viewer._show(taken)
    viewer.label.set_text.assert_called_with("pair 1 (0 to 2): 1 matched points")
    viewer._show(viewer._take())
    viewer.label.set_text.assert_called_with("pair 2 (0 to 2): 2 matched points")
