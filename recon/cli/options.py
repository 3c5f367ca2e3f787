"""Options that several commands share, and the settings they make."""

import json
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])
PATH = click.Path(path_type=Path)

OUTPUT = [
    click.option("--json", "as_json", is_flag=True, help="Print one JSON document on stdout."),
    click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors."),
    click.option("-v", "--verbose", is_flag=True, help="Say what is being done."),
]

SETTINGS = [
    click.option("--settings", "settings_file", type=PATH, help="A TOML file of settings."),
    click.option("--set", "overrides", multiple=True, metavar="STAGE.NAME=VALUE"),
    click.option("--preset", type=click.Choice(["default", "thesis"]), default="default"),
]

FOLDER = [
    click.option("-o", "--output", type=PATH, help="The run folder; runs/NAME where not given."),
    click.option("--overwrite", is_flag=True, help="Replace an existing run."),
    click.option("--resume", is_flag=True, help="Go on with a run that was cut."),
    click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True),
]

MATCHING = [
    click.option("--matcher", help="phase, vonmises, sgbm, or a plug-in's name."),
    click.option("--quality", type=click.Choice(["best", "fast"])),
    click.option("--keep", type=click.IntRange(min=1), help="Keep the K most confident pairs."),
]


def with_options(*groups: list[Callable[[Command], Command]]) -> Callable[[Command], Command]:
    """A decorator that adds the options of all groups, in their order."""

    def decorate(command: Command) -> Command:
        for option in reversed([option for group in groups for option in group]):
            command = option(command)
        return command

    return decorate


def build_settings(
    *,
    preset: str = "default",
    settings_file: Path | None = None,
    overrides: tuple[str, ...] = (),
    quality: str | None = None,
    flags: dict[str, Any] | None = None,
    base: dict[str, Any] | None = None,
    base_quality: str = "best",
) -> Any:
    """Settings from weakest to strongest: base, preset, file, quality, flags, --set.

    `flags` and `base` map "stage.name" to a value; flags that are None were not given. The base
    is what a command asks for by itself.
    """
    from recon.settings import Settings, parse_overrides, read_toml, updated, with_preset
    from recon.settings import with_quality as qualified

    settings = qualified(Settings(), "fast" if base_quality == "fast" else "best")
    settings = with_preset(updated(settings, _tree(base or {})), preset)
    if settings_file is not None:
        settings = updated(settings, read_toml(settings_file), str(settings_file))
    if quality is not None:
        settings = qualified(settings, "fast" if quality == "fast" else "best")
    settings = updated(settings, _tree(flags or {}), "options")
    return updated(settings, parse_overrides(overrides), "--set")


def _tree(flat: dict[str, Any]) -> dict[str, dict[str, Any]]:
    tree: dict[str, dict[str, Any]] = {}
    for key, value in flat.items():
        stage, _, name = key.partition(".")
        if value is not None:
            tree.setdefault(stage, {})[name] = value
    return tree


class StderrHandler(logging.Handler):
    """Logs as lines on stderr."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one record."""
        click.echo(f"recon: {record.getMessage()}", err=True)


def start_logging(quiet: bool, verbose: bool) -> None:
    """Logs go to stderr: warnings, or everything with -v, or errors with -q."""
    logger = logging.getLogger("recon")
    logger.setLevel(logging.ERROR if quiet else logging.INFO if verbose else logging.WARNING)
    logger.handlers[:] = [StderrHandler()]


def stop_logging() -> None:
    """Leave logging as a library has it: to whoever imports recon."""
    logger = logging.getLogger("recon")
    logger.setLevel(logging.NOTSET)
    logger.handlers.clear()


def print_json(document: object) -> None:
    """The one document of --json."""
    click.echo(json.dumps(document, indent=2, allow_nan=False))
