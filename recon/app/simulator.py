"""The simulator: a world in a browser."""

from pathlib import Path
from typing import Any

from recon.app.serving import Address, serve
from recon.app.visitors import Visitors
from recon.settings import Settings
from recon.world.library import find_scene
from recon.world.scene import read_scene


def simulate(scene: Path, settings: Settings | None, address: Address, announce: Any) -> None:
    """Show a world in a browser until Ctrl-C.

    Raises
    ------
    InputError
        If the scene cannot be read.
    """
    path = find_scene(scene)
    read_scene(path)

    def build() -> None:
        # Late: the browser starts meanwhile.
        from recon.app.simulator_page import SimulatorPage

        SimulatorPage(visitors.current())

    def visit() -> Any:
        from recon.app.visit import Visit

        return Visit(path, settings)

    visitors: Visitors[Any] = Visitors(visit)
    serve(build, address, f"recon simulate {path.stem}", announce)
