"""Objects as printed on the terminal."""

import math
from collections.abc import Sequence
from typing import Any

import click


def say_objects(objects: Sequence[dict[str, Any]]) -> None:
    """Print one line for each object: its name, position, size and what is unknown."""
    for found in objects:
        click.echo(object_line(found))


def object_line(found: dict[str, Any]) -> str:
    """One object of an `objects.json`."""
    chance = found["probability"]
    said = "" if chance is None else f"   {chance:.0%}"
    box = found.get("box")
    decimals = _decimals(box)
    place = ", ".join(_rounded(value, decimals) for value in found["centre"])
    return f"{found['label']:14} at {place}{_size(found, decimals)}{said}{_reason(found)}"


def _size(found: dict[str, Any], decimals: int) -> str:
    """The size of what has a name, from the ground up; else the edges of the box of its cells."""
    # Late: listing the commands needs no arrays.
    from recon.records.objects import UNKNOWN

    box = found.get("box")
    if box is None:
        return ""
    lengths = box["sizes"] if found["label"] == UNKNOWN else found["size"]
    edges = " x ".join(_rounded(edge, decimals) for edge in lengths)
    return f"   {edges} {box['unit'] or ''}".rstrip()


def _decimals(box: dict[str, Any] | None) -> int:
    """Decimals that leave two digits of the longest edge; at least two."""
    longest = max(box["sizes"]) if box else 0.0
    return max(2, 1 - math.floor(math.log10(longest))) if longest > 0 else 2


def _rounded(value: float, decimals: int) -> str:
    """The number as text, without a negative zero."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}"


def _reason(found: dict[str, Any]) -> str:
    """The reason why it has no name, if a catalogue was used."""
    if found["probability"] is None or not found.get("reason"):
        return ""
    return f"   ({found['reason']})"
