"""Untrusted TOML, JSON and YAML, read within limits of size, nesting and digits."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import yaml

from recon.errors import InputError, one_line
from recon.files.atomic import PathLike
from recon.files.limits import check_regular

MAX_BYTES = 1 << 28
MAX_NESTING = 60
MAX_DIGITS = 400
"""Of a number: more than any float has."""

# A dotted TOML key creates a table for each of its parts; YAML and JSON have no such thing.
MAX_SETTINGS_BYTES = 1 << 20
_MAX_KEY_PARTS = 20

_LONG_NUMBER = re.compile(rb"[0-9]{401,}")
_DOTTED_KEY = re.compile(r"(?m)^[^=\"'#\n]*(?:\.[^=\"'#.\n]+){20,}")
_MAX_ALIASES = 100


def read_text(path: PathLike, max_bytes: int = MAX_BYTES) -> str:
    """The text of a regular UTF-8 file.

    Raises
    ------
    InputError
        If it is larger than `max_bytes`, not UTF-8, or contains a number with too many digits.
    """
    check_regular(path)
    size = Path(path).stat().st_size
    if size > max_bytes:
        raise InputError(f"{path}: has {size} bytes, but at most {max_bytes} are allowed")
    content = Path(path).read_bytes()
    if _LONG_NUMBER.search(content):
        raise InputError(f"{path}: contains a number with more than {MAX_DIGITS} digits")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text (byte {error.start})") from error


def read_json(path: PathLike) -> Any:
    """The content of a JSON file.

    Raises
    ------
    InputError
        If it is not JSON, or nested too deeply.
    """
    return parse_json(read_text(path), path)


def parse_json(text: str, path: PathLike) -> Any:
    """The content of a JSON text read from `path`."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not a JSON document ({_reason(error)})") from error


def read_toml(path: PathLike) -> dict[str, Any]:
    """The content of a TOML file.

    Raises
    ------
    InputError
        If it is not TOML, or larger or more deeply nested than settings are.
    """
    return parse_toml(read_text(path, MAX_SETTINGS_BYTES), path)


def parse_toml(text: str, path: PathLike) -> dict[str, Any]:
    """The content of a TOML text read from `path`."""
    if _DOTTED_KEY.search(text):
        raise InputError(f"{path}: a key has more than {_MAX_KEY_PARTS} parts")
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{path}: {_reason(error)}, but a TOML file is needed") from error


def read_yaml(path: PathLike) -> Any:
    """The content of a YAML file as plain values; nothing in it is executed."""
    return parse_yaml(read_text(path, MAX_SETTINGS_BYTES), path)


def parse_yaml(text: str, path: PathLike) -> Any:
    """The content of a YAML text read from `path`.

    Raises
    ------
    InputError
        If it is not YAML, is nested too deeply or has too many aliases.
    """
    try:
        _check_events(text, path)
        return yaml.load(text, Loader=yaml.CSafeLoader)
    except (yaml.YAMLError, ValueError, RecursionError, OverflowError) as error:
        raise InputError(f"{path}: not a YAML file ({_reason(error)})") from error


def _check_events(text: str, path: PathLike) -> None:
    depth = aliases = 0
    for event in yaml.parse(text, Loader=yaml.CSafeLoader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        aliases += isinstance(event, yaml.AliasEvent)
        if depth > MAX_NESTING or aliases > _MAX_ALIASES:
            raise InputError(
                f"{path}: is nested deeper than {MAX_NESTING}, or has too many aliases"
            )


def _reason(error: Exception) -> str:
    return "nested too deeply" if isinstance(error, RecursionError) else one_line(error)
