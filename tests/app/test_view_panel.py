"""The view of the inspector: what is chosen while it is drawn is drawn next."""

from unittest.mock import MagicMock

import numpy as np
import pytest

from recon.app import filters, view_panel
from recon.app.filters import Filter
from recon.app.layers import layer_of
from recon.records import PointCloud


def layer(number):
    points = np.random.default_rng(2).random((number, 3))
    return layer_of(PointCloud(points=points, sigma=np.arange(float(number))))


@pytest.fixture
def panel(monkeypatch):
    """A view of 300 points without a page."""
    for name in ("pane", "nicegui", "Painter"):
        monkeypatch.setattr(view_panel, name, MagicMock())
    return view_panel.ViewPanel("scene", layer(300), *[MagicMock() for _ in range(3)])


def draw_while(monkeypatch, panel, change):
    """Draw the view while the page changes something."""
    shown = filters.shown

    def interrupted(*given):
        monkeypatch.setattr(filters, "shown", shown)
        change()
        return shown(*given)

    monkeypatch.setattr(filters, "shown", interrupted)
    return panel._draw()


def test_filter_chosen_while_the_view_is_drawn_is_applied_next(panel, monkeypatch):
    few = Filter(most={"sigma": 9.0})
    before = draw_while(monkeypatch, panel, lambda: panel.refilter(few))
    assert before.shown.num_kept == 300
    assert panel._draw().shown.num_kept == 10


def test_layer_chosen_while_the_view_is_drawn_is_drawn_next(panel, monkeypatch):
    before = draw_while(monkeypatch, panel, lambda: panel.change_layer(layer(20)))
    assert before.shown.num_all == 300
    assert panel._draw().shown.num_all == 20


def test_click_on_a_view_of_the_previous_layer_picks_nothing(panel):
    panel._show(panel._draw())
    v, u = np.nonzero(panel.view.number > 100)
    panel._pick((u[0], v[0]))
    assert panel.picked > 100
    panel.change_layer(layer(20))
    panel._pick((u[0], v[0]))
    assert panel.picked is None
