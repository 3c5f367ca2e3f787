"""One visit of the simulator."""

from pathlib import Path

from recon.app.simulation import Simulation
from recon.app.walk import Walk
from recon.settings import Settings


class Visit:
    """The cameras and the exploration of one visitor."""

    def __init__(self, scene: Path, settings: Settings | None) -> None:
        self.simulation = Simulation(scene, settings)
        self.walk: Walk | None = None
