"""Catalogues: kinds of objects in TOML, shipped or user-written."""

import os
import re
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from recon.errors import InputError
from recon.files.documents import MAX_SETTINGS_BYTES, parse_toml, read_text
from recon.recognition.naming.kinds import Kind
from recon.settings.stage import STRICT, first_fault

FOLDER = Path(__file__).with_name("catalogues")
NONE = "none"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Catalogue:
    """All kinds of a catalogue file."""

    object: Annotated[tuple[Kind, ...], Field(min_length=1)]


def shipped_names() -> list[str]:
    """Names of the catalogues that come with recon; "none" has no kinds."""
    return [*sorted(path.stem for path in FOLDER.glob("*.toml")), NONE]


def read_catalogues(names: Sequence[str]) -> tuple[Kind, ...]:
    """The kinds of several catalogues, each a shipped name or a file.

    Kinds with the same name are alternatives: an object may match any of them.

    Raises
    ------
    InputError
        If a catalogue does not exist, or with the file, line and error if it is invalid.
    """
    return tuple(kind for name in names if name != NONE for kind in read_catalogue(_path(name)))


def _path(name: str) -> Path:
    known = shipped_names()
    path = FOLDER / f"{name}.toml" if name in known else Path(name)
    # Path.is_file() raises for a name that is too long to be a file's.
    if not os.path.isfile(path):  # noqa: PTH113
        named = ", ".join(known)
        raise InputError(f"catalogue is {name!r}, but a TOML file or one of {named} is needed")
    return path


def read_catalogue(path: Path) -> tuple[Kind, ...]:
    """The kinds of a catalogue file.

    Raises
    ------
    InputError
        With the file, line and first error, if the file is invalid.
    """
    try:
        text = read_text(path, MAX_SETTINGS_BYTES)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}, but a catalogue is needed") from error
    return _kinds(text, path)


@lru_cache(maxsize=16)
def _kinds(text: str, path: Path) -> tuple[Kind, ...]:
    """The kinds that a text holds, worked out once while it stays the same."""
    try:
        document = parse_toml(text, path)
        kinds: tuple[Kind, ...] = TypeAdapter(Catalogue).validate_python(document).object
    except ValidationError as error:
        line = line_of(text, error.errors()[0]["loc"])
        raise InputError(f"{path}:{line}: {first_fault(error)}") from error
    return kinds


def line_of(text: str, location: Sequence[Any]) -> int:
    """Line number in a TOML text that a location like ("object", 1, "name") refers to.

    If the value itself is missing, the line of the table that should contain it.
    """
    lines = text.splitlines() or [""]
    low, high = 0, len(lines)
    if len(location) > 1:
        low, high = _nth_block(lines, r"\s*\[\[\s*object\s*\]\]", int(location[1]), low, high)
    steps = list(location[2:])
    if steps[:1] == ["parts"] and len(steps) > 1:
        part = r"\s*(\[\[\s*object\s*\.\s*parts\s*\]\]|.*\{.*\brole\b)"
        low, high = _nth_block(lines, part, int(steps[1]), low, high)
        steps = steps[2:]
    keys = [re.compile(rf"(^|[\s{{,.]){re.escape(str(step))}\s*[=.]") for step in steps]
    named = [row for row in range(low, high) if any(key.search(lines[row]) for key in keys)]
    return (named[-1] if len(keys) > 1 and named else named[0] if named else low) + 1


def _nth_block(lines: list[str], opening: str, number: int, low: int, high: int) -> tuple[int, int]:
    """First row of the block that starts at the nth opening, and the row after its last."""
    starts = [row for row in range(low, high) if re.match(opening, lines[row])]
    if number >= len(starts):
        return low, high
    return starts[number], starts[number + 1] if number + 1 < len(starts) else high
