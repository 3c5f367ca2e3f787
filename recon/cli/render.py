"""`recon render`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import counted, do_job
from recon.cli.options import OUTPUT, PATH, SCENE, SETTINGS, run_folder, with_options

if TYPE_CHECKING:
    from recon.runs.report import Report


@click.command(epilog="Example: recon render village --views ring:20 --set render.noise=2 -o ring")
@click.argument("scene", type=PATH)
@click.option(
    "--views", default="ring:20", show_default=True, metavar="ring:N|drive:N|FILE",
    help="ring:N, drive:N, or a file with a position and a target per row.",
)  # fmt: skip
@with_options(SCENE, SETTINGS, run_folder("runs/NAME_views"), OUTPUT)
def render(scene: Path, **given: Any) -> None:
    """Render a stereo recording of a scene or a mesh, with true disparity, depth and surface.

    The settings `render.*` hold noise, blur and the gain of the right camera, `eyes.*` the cameras.
    """
    do_job("render", (scene,), given, say=_say, unit="views", views=given["views"])


def _say(report: "Report") -> None:
    click.echo(
        f"{counted(report['num_pairs'], 'pair')}, disparities up to {report['max_disparity']} px"
    )
    click.echo(report.run)
