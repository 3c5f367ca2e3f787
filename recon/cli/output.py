"""Output of a command: one JSON document or lines for people, and logs on stderr."""

import json
import logging
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import click

from recon.notices import Notice, collected_notices

if TYPE_CHECKING:
    from recon.runs.report import Report

_NOTICES = "recon.notices"


def start_logging(given: Mapping[str, Any]) -> None:
    """Logs go to stderr: warnings, or everything with -v, or errors with -q.

    What is notified from now on is a warning of the command's document.
    """
    loudest = logging.INFO if given["verbose"] else logging.WARNING
    logger = logging.getLogger("recon")
    logger.setLevel(logging.ERROR if given["quiet"] else loudest)
    logger.handlers[:] = [StderrHandler()]
    context = click.get_current_context()
    context.meta[_NOTICES] = context.with_resource(collected_notices())


def stop_logging() -> None:
    """Leave logging to the importing program, as a library should."""
    logger = logging.getLogger("recon")
    logger.setLevel(logging.NOTSET)
    logger.handlers.clear()


def print_document(
    given: Mapping[str, Any], document: Mapping[str, Any], lines: Iterable[object]
) -> None:
    """Print the one document of --json, else lines for people unless only errors are wanted.

    Parameters
    ----------
    given : mapping
        The options of a command.
    document : mapping
        The notices of the command are added as `warnings`, if it has none.
    lines : iterable
        Read only if they are printed.
    """
    if given["as_json"]:
        notices: list[Notice] = click.get_current_context().meta[_NOTICES]
        warnings = {"warnings": [notice.as_json() for notice in notices]}
        complete = document if "warnings" in document else {**document, **warnings}
        click.echo(json.dumps(complete, indent=2, allow_nan=False))
    elif not given["quiet"]:
        for line in lines:
            click.echo(line)


def shown(value: Any) -> str:
    """One value in a readable form."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(map(shown, value)) or "none"
    return str(value) if value != {} else "none"


def say_numbers(report: "Report") -> None:
    """Print the numbers of a report, one a line, and the run folder if there is one."""
    for name, value in report.numbers.items():
        click.echo(f"{name:24} {shown(value)}")
    if report.run is not None:
        click.echo(report.run)


class StderrHandler(logging.Handler):
    """Logs as lines on stderr."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one record."""
        click.echo(f"recon: {record.getMessage()}", err=True)
