"""A bar on stderr, where that is a terminal; and a word before the one long wait."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click
from tqdm import tqdm

if TYPE_CHECKING:
    from recon.runs.events import Events


@contextmanager
def shown_progress(unit: str, quiet: bool) -> Iterator["Events"]:
    """Events that move a bar and name the stage beside it."""
    from recon.runs.events import Events

    silent = quiet or not sys.stderr.isatty()
    with tqdm(unit=f" {unit}", disable=silent, file=sys.stderr, leave=False) as bar:
        stages: set[str] = set()

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        def name(stage: str) -> None:
            if stage == "compiling" and stage not in stages and not quiet:
                bar.clear()
                click.echo("recon: compiling, which only the first run has to", err=True)
            stages.add(stage)
            bar.set_postfix_str(stage)

        yield Events(on_progress=show, on_stage=name)
