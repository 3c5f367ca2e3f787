"""Which activity of the thesis's controller follows which, counted on a walk."""

from collections import Counter

import recon
from recon.exploration.thesis import ThesisController
from recon.records import View
from recon.settings import Settings, with_preset
from recon.world.library import find_scene
from recon.world.world import World

ACTIVITIES = {"_circle": "turn round an object", "_meet": "meet what is new",
              "_turn": "turn on the spot", "_head": "head for the unexplored"}  # fmt: skip


class Watched(ThesisController):
    """The controller, and the activity of each of its answers."""

    seen: list[str]


def transitions(scene: str) -> dict[tuple[str, str], int]:
    """How often one activity followed another."""
    names: list[str] = ["look"]

    class Told(ThesisController):
        """Notes which activity gave the next view."""

        def next_view(self, state: object) -> View | None:
            view = super().next_view(state)  # type: ignore[arg-type]
            names.append(self.activity)
            return view

    raise NotImplementedError(Told, Counter, recon, find_scene, World, Settings, with_preset)
