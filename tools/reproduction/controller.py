"""Transitions between activities of the thesis's controller, counted in one exploration."""

import itertools
from collections import Counter
from typing import Any

from recon.exploration.agent import explore
from recon.exploration.thesis import ThesisController
from recon.settings import Settings, explorers, with_preset
from recon.world.library import find_scene
from recon.world.world import World

ACTIVITIES = {
    "_circle": "turn round an object",
    "_meet": "meet what is new",
    "_turn": "turn on the spot",
    "_head": "head for the unexplored",
}
START = "look"


class RecordingController(ThesisController):
    """The controller, with the activity that gave each of its views."""

    def __init__(self) -> None:
        super().__init__()
        self.names = [START]

    def next_view(self, state: Any) -> Any:
        """Choose the next view, and record the innermost activity that gave it."""
        self.last = ""
        view = super().next_view(state)
        self.names.append(self.last or "end")
        return view


def _recorded(name: str) -> Any:
    def activity(self: RecordingController, *given: Any) -> Any:
        view = getattr(ThesisController, name)(self, *given)
        if view is not None and not self.last:
            self.last = ACTIVITIES[name]
        return view

    return activity


for _name in ACTIVITIES:
    setattr(RecordingController, _name, _recorded(_name))


def transitions(scene: str) -> dict[tuple[str, str], int]:
    """Count how often one activity followed another."""
    settings = explorers(with_preset(Settings(), "thesis"))
    controller = RecordingController()
    explore(World.from_file(find_scene(scene), settings), settings, controller=controller)
    return dict(Counter(itertools.pairwise(controller.names)))
