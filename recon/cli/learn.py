"""`recon learn`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import counted, do_job
from recon.cli.options import OUTPUT, PATH, SETTINGS, with_options

if TYPE_CHECKING:
    from recon.runs.report import Report


@click.command(epilog="Example: recon learn mug_1.ply runs/desk#3 --name mug -o kinds.toml")
@click.argument("examples", nargs=-1, required=True)
@click.option("--name", required=True, help="Name of the kind.")
@click.option(
    "--unit", "recognition__unit", type=click.Choice(["m"]), help="Unit of length in EXAMPLES."
)
@click.option("-o", "--output", "catalogue", type=PATH, required=True, help="Catalogue to write.")
@with_options(SETTINGS, OUTPUT)
def learn(examples: tuple[str, ...], catalogue: Path, name: str, **given: Any) -> None:
    """Learn a kind of object from clouds, maps or objects of runs (RUN#ID)."""
    do_job(
        "learn", _inputs(examples), given, say=_say, name=name, catalogue=str(catalogue),
        examples=examples,
    )  # fmt: skip


def _inputs(examples: tuple[str, ...]) -> tuple[Path, ...]:
    """The input files; for RUN#ID, the run."""
    names = (text if Path(text).exists() else text.rpartition("#")[0] for text in examples)
    return tuple(map(Path, names))


def _say(report: "Report") -> None:
    click.echo(f"{report['name']}: learned from {counted(report['num_examples'], 'example')}")
    for group in report["descriptors"]:
        use = "used" if group["used"] else "left out"
        click.echo(f"{use:9} {group['name']}: {group['reason']}")
    click.echo(f"names from it have a probability of at most {report['highest_probability']:.0%}")
    click.echo(report["catalogue"])
