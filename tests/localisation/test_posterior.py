"""A side of a thing that no pair has shown may look like the one that is seen."""

import pytest

from recon.localisation.look import Look
from recon.localisation.portrait import Portrait
from recon.localisation.posterior import Posterior
from recon.localisation.standpoints import Standpoint
from tests.localisation.trees import taken, tree


@pytest.mark.parametrize(
    ("sides", "may_repeat"), [((60, 120), True), ((0, 60, 120, 180, 240, 300), False)]
)
def test_an_unseen_side_may_repeat_a_seen_one(sides, may_repeat):
    pair, portrait = taken(30), Portrait.of((tree(),), [taken(side) for side in sides], 1.0)
    best = Standpoint(T_world_left=pair.T_world_left, thing=0, value=0.0)
    assert Posterior.of(portrait, Look(pair=pair), best).may_repeat() == may_repeat
