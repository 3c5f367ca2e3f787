"""TOML, JSON and YAML of others: read within bounds of size, nesting and digits."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import yaml

from recon.errors import InputError
from recon.files.atomic import PathLike
from recon.files.limits import check_regular

MAX_BYTES = 1 << 28
MAX_NESTING = 60
MAX_DIGITS = 400
"""Of a number: more than any float has."""

# A TOML key of many parts makes a table for each of them, of which YAML and JSON have no like.
MAX_SETTINGS_BYTES = 1 << 20
_MAX_KEY_PARTS = 20

_LONG_NUMBER = re.compile(rb"[0-9]{401,}")
_DOTTED_KEY = re.compile(r"(?m)^[^=\"'#\n]*(?:\.[^=\"'#.\n]+){20,}")
_MAX_ALIASES = 100


def read_text(path: PathLike, max_bytes: int = MAX_BYTES) -> str:
    """The text of a regular file, in UTF-8.

    Raises
    ------
    InputError
        Where it is larger than `max_bytes`, not UTF-8, or holds a number of too many digits.
    """
    check_regular(path)
    size = Path(path).stat().st_size
    if size > max_bytes:
        raise InputError(f"{path}: has {size} bytes, but {max_bytes} are the most")
    content = Path(path).read_bytes()
    if _LONG_NUMBER.search(content):
        raise InputError(f"{path}: holds a number of more than {MAX_DIGITS} digits")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not text in UTF-8 (byte {error.start})") from error


def read_json(path: PathLike) -> Any:
    """The content of a JSON file.

    Raises
    ------
    InputError
        Where it is not JSON, or nested too deeply.
    """
    return parse_json(read_text(path), path)


def parse_json(text: str, path: PathLike) -> Any:
    """The content of a JSON text of `path`."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not a JSON document ({_reason(error)})") from error


def read_toml(path: PathLike) -> dict[str, Any]:
    """The content of a TOML file.

    Raises
    ------
    InputError
        Where it is not TOML, or larger or nested deeper than settings are.
    """
    return parse_toml(read_text(path, MAX_SETTINGS_BYTES), path)


def parse_toml(text: str, path: PathLike) -> dict[str, Any]:
    """The content of a TOML text of `path`."""
    if _DOTTED_KEY.search(text):
        raise InputError(f"{path}: a key has more than {_MAX_KEY_PARTS} parts")
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{path}: {_reason(error)}, but a TOML file is needed") from error


def read_yaml(path: PathLike) -> Any:
    """The content of a YAML file, in plain values; nothing in it is run."""
    return parse_yaml(read_text(path, MAX_SETTINGS_BYTES), path)


def parse_yaml(text: str, path: PathLike) -> Any:
    """The content of a YAML text of `path`.

    Raises
    ------
    InputError
        Where it is not YAML, nested too deeply, or its aliases multiply.
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
            raise InputError(f"{path}: is nested deeper than {MAX_NESTING}, or repeats too much")


def _reason(error: Exception) -> str:
    if isinstance(error, RecursionError):
        return "nested too deeply"
    return " ".join(str(error).split())[:200]
