"""Settings as TOML, and overrides by name."""

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import TypeAdapter, ValidationError

from recon.errors import InputError
from recon.settings.settings import Settings
from recon.settings.world import FOLLOWERS

Tree = dict[str, dict[str, Any]]


def to_tree(settings: Settings) -> Tree:
    """All values by stage and name; None is the word "none", as TOML has no None."""
    return {
        stage: {name: "none" if value is None else value for name, value in values.items()}
        for stage, values in asdict(settings).items()
    }


def to_toml(settings: Settings) -> str:
    """The text of `settings.toml`."""
    return tomli_w.dumps(to_tree(settings))


def read_toml(path: Path) -> Tree:
    """The tables of a settings file; its values are checked by `updated`."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: {error}, but a TOML file is needed") from error


def parse_overrides(overrides: Iterable[str]) -> Tree:
    """Tables from lines "stage.name=value", the value as TOML has it or a bare word."""
    tree: Tree = {}
    for line in overrides:
        key, equals, text = line.partition("=")
        stage, dot, name = key.strip().partition(".")
        if not (equals and dot and name):
            raise InputError(f"--set is {line!r}, but stage.name=value is needed")
        tree.setdefault(stage, {})[name] = _value(text.strip())
    return tree


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def updated(settings: Settings, changes: Mapping[str, Any], source: str = "settings") -> Settings:
    """`settings` with the values of `changes`, all of them checked; the word "none" is None.

    Raises
    ------
    InputError
        For an unknown name, with the nearest known one, and for a value out of its range.
    """
    tree: dict[str, Any] = asdict(settings)
    for stage, values in changes.items():
        _check_known(stage, tree, source)
        if not isinstance(values, Mapping):
            raise InputError(f"{source}: {stage} is {values!r}, but a table is needed")
        for name, value in values.items():
            _check_known(f"{stage}.{name}", {f"{stage}.{known}" for known in tree[stage]}, source)
            tree[stage][name] = None if value == "none" else value
            if FOLLOWERS.get(name, name) not in values:
                tree[stage].pop(FOLLOWERS[name])
    return _checked(tree, source)


def _check_known(name: str, known: Iterable[str], source: str) -> None:
    known = list(known)
    if name not in known:
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)
        raise InputError(f"{source}: {name} is unknown; the nearest known name is {near[0]}")


def _checked(tree: Mapping[str, Any], source: str) -> Settings:
    try:
        return TypeAdapter(Settings).validate_python(tree)
    except ValidationError as error:
        first = error.errors()[0]
        name = ".".join(str(step) for step in first["loc"])
        message = first["msg"].removeprefix("Value error, ")
        # What is wrong with a whole stage says its own values.
        value = "" if isinstance(first["input"], dict) else f" is {first['input']!r}"
        raise InputError(f"{source}: {name}{value}: {message}") from error
