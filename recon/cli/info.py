"""`recon info`."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, SCENE, with_options
from recon.cli.output import print_document, shown, start_logging

_INDENT = "  "


@click.command(epilog="Example: recon info runs/village")
@click.argument("file", type=PATH)
@with_options(SCENE, OUTPUT)
def info(file: Path, **given: Any) -> None:
    """Describe anything that recon reads or writes: a run, recording, cloud, map, mesh, ..."""
    start_logging(given)
    from recon.runs.description import describe
    from recon.runs.outputs import as_document

    facts = as_document(describe(file))
    shown_facts = {name: value for name, value in facts.items() if name != "warnings"}
    print_document(given, facts, lines(shown_facts))


def lines(facts: Mapping[str, Any], indent: str = "") -> Iterator[str]:
    """Facts as lines: a word or number beside its name, tables and mappings below theirs."""
    for name, value in facts.items():
        if isinstance(value, dict) and value:
            yield f"{indent}{name}"
            yield from lines(value, indent + _INDENT)
        elif isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
            yield f"{indent}{name}"
            yield from (indent + _INDENT + line for line in table(value))
        else:
            yield f"{indent}{name:20} {shown(value)}"


def table(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Rows under the names of their columns, each as wide as its widest value."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    cells = [names, *([shown(row.get(name)) for name in names] for row in rows)]
    widths = [max(len(line[n]) for line in cells) for n in range(len(names))]
    for line in cells:
        padded = (f"{cell:{width}}" for cell, width in zip(line, widths, strict=True))
        yield "  ".join(padded).rstrip()
