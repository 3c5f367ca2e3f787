"""Objects as the terminal shows them."""

from collections.abc import Sequence
from typing import Any

import click


def say_objects(objects: Sequence[dict[str, Any]]) -> None:
    """Print one line for each object: its name, place, size and what is not known of it."""
    for found in objects:
        click.echo(object_line(found))


def object_line(found: dict[str, Any]) -> str:
    """One object of an `objects.json`."""
    place = ", ".join(f"{value:.2f}" for value in found["centre"])
    chance = found["probability"]
    said = "" if chance is None else f"   {chance:.0%}"
    return f"{found['label']:14} at {place}{_size(found.get('box'))}{said}{_reason(found)}"


def _size(box: dict[str, Any] | None) -> str:
    if box is None:
        return ""
    edges = " x ".join(f"{edge:.2f}" for edge in box["sizes"])
    return f"   {edges} {box['unit'] or ''}".rstrip()


def _reason(found: dict[str, Any]) -> str:
    """Why it has no name, where a catalogue was asked."""
    if found["probability"] is None or not found.get("reason"):
        return ""
    return f"   ({found['reason']})"
