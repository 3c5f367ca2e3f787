"""The simulator's page: four panes, movable cameras, and a live exploration."""

from recon.app.camera_card import CameraCard
from recon.app.image_panes import ImagePanes
from recon.app.map_views import MapViews
from recon.app.run_card import RunCard
from recon.app.settings_card import SettingsCard
from recon.app.visit import Visit
from recon.app.walk import Walk
from recon.app.widgets import header, nicegui, note, side
from recon.errors import ReconError

POLL_S = 0.4
"""Interval of polling the exploration, seconds."""


class SimulatorPage:
    """The page of one visitor."""

    def __init__(self, visit: Visit) -> None:
        self.visit = visit
        self.simulation = visit.simulation
        ui = nicegui()
        header("recon simulate", self.simulation.scene.name)
        with ui.element("div").classes("recon-page"):
            with ui.element("div").classes("recon-main"):
                with ui.element("div").classes("recon-panes recon-four"):
                    self.images = ImagePanes(self.simulation, self.say)
                    self.maps = MapViews(visit, self.moved, self.say)
                self.message = note("message", "", "recon-message")
            with side():
                self.camera = CameraCard(self.simulation, self.moved, self.say)
                self.images.add_card()
                self.run = RunCard(visit, self.say)
                SettingsCard(self.simulation, self.changed, self.say)
        self._drawn = -1
        ui.timer(POLL_S, self._poll)
        self.changed()

    def say(self, text: str) -> None:
        """Show an error message; empty if there is none."""
        self.message.set_text(text)

    def moved(self) -> None:
        """Update the page after the cameras have changed."""
        self.say("")
        self.camera.show()
        self.maps.mark()
        self.images.painter.ask()

    def changed(self) -> None:
        """Update the page after the look of the world has changed."""
        self.maps.painter.ask()
        self.moved()

    def _poll(self) -> None:
        if self.images.sight is not None:
            # Late: the images come first.
            self.run.introduce()
        walk = self.visit.walk
        if walk is None:
            return
        walk.check()
        self.run.show()
        if walk.number != self._drawn or walk.is_over:
            self._drawn = walk.number
            self._follow(walk)

    def _follow(self, walk: Walk) -> None:
        """Show the position of the exploration, and its map."""
        simulation = self.simulation
        if simulation.objects != walk.objects:
            simulation.objects = walk.objects
            self.maps.table.show(walk.objects)
        if walk.last is not None and not walk.is_over:
            try:
                simulation.move(walk.last.view.position, walk.last.view.target)
            except ReconError as error:
                self.say(str(error))
            self.camera.show()
            self.images.painter.ask()
        self.maps.painter.ask()
