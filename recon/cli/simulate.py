"""`recon simulate`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, SCENE, SETTINGS, build_settings, with_options
from recon.cli.output import start_logging
from recon.cli.pages import SERVER, announced


@click.command(epilog="Example: recon simulate scenes/village.scene")
@click.argument("scene", type=PATH)
@with_options(SERVER, SCENE, SETTINGS, OUTPUT)
def simulate(scene: Path, **given: Any) -> None:
    """View a simulated world in a browser, and lead the agent through it."""
    start_logging(given)
    from recon.app.serving import listen
    from recon.app.simulator import simulate as show
    from recon.settings import explorers

    settings = explorers(build_settings(given))
    address = listen(given["host"], given["port"])
    show(scene, settings, address, announced(address.url, given))
