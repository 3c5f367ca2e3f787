"""A side of a thing that no pair has shown may look like the one that is seen."""

from types import SimpleNamespace

import numpy as np
import pytest

from recon.localisation.look import Look
from recon.localisation.portrait import Portrait
from recon.localisation.posterior import Posterior
from recon.localisation.standpoints import Standpoint, orbited
from tests.localisation.trees import taken, tree


@pytest.mark.parametrize(
    ("sides", "may_repeat"), [((60, 120), True), ((0, 60, 120, 180, 240, 300), False)]
)
def test_an_unseen_side_may_repeat_a_seen_one(sides, may_repeat):
    pair, portrait = taken(30), Portrait.of((tree(),), [taken(side) for side in sides], 1.0)
    best = Standpoint(T_world_left=pair.T_world_left, thing=0, value=0.0)
    assert Posterior.of(portrait, Look(pair=pair), best).may_repeat() == may_repeat


@pytest.mark.parametrize(
    ("turn_deg", "lost_per_px", "is_turned"),
    [(180.0, 0.24, True), (120.0, -1.0, True), (180.0, 0.85, False), (50.0, 0.24, False)],
)
def test_a_rival_turned_about_the_thing_is_a_repeat_unless_the_image_tells(
    turn_deg, lost_per_px, is_turned
):
    centre, here = np.array([3.0, 0.0, -20.0]), np.eye(4)
    best = Standpoint(T_world_left=here, thing=0, value=5000.0)
    posterior = Posterior(
        portrait=SimpleNamespace(centre=lambda _: centre, cell_size=1.0),
        look=None, best=best, num_shown=1000, num_explained=1000,
    )  # fmt: skip
    turned = orbited(here, centre, np.radians(turn_deg))
    rival = Standpoint(T_world_left=turned, thing=0, value=5000.0 - 1000 * lost_per_px)
    assert posterior.is_turned(rival) is is_turned
