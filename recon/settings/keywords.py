"""Settings from the keywords of a Python call."""

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

from recon.errors import InputError, unknown
from recon.settings.files import STAGES, given_tree, updated
from recon.settings.presets import PRESETS, QUALITIES, with_preset, with_quality
from recon.settings.stage import given
from recon.settings.stages import S


def by_keyword(
    empty: S,
    settings: S | None,
    *,
    preset: str = "default",
    quality: str | None = None,
    **values: Any,
) -> S:
    """`empty` overridden by a preset, a quality, `settings` and `values`, in this order."""
    _check_choice("preset", preset, PRESETS)
    chosen = with_preset(empty, preset)
    if quality is not None:
        _check_choice("quality", quality, QUALITIES)
        chosen = with_quality(chosen, "best" if quality == "best" else "fast")
    if settings is not None:
        if not isinstance(settings, type(empty)):
            raise InputError(f"settings is a {type(settings).__name__}, but Settings are needed")
        chosen = updated(chosen, given_tree(settings))
    for name, value in values.items():
        chosen = updated(chosen, _tree(name, value))
    return chosen


def _check_choice(name: str, value: str, choices: Iterable[str]) -> None:
    if value not in choices:
        raise InputError(f"{name} is {value!r}, but one of {', '.join(choices)} is needed")


def _tree(name: str, value: Any) -> dict[str, Any]:
    """The tree of one keyword."""
    stage, dot, rest = name.partition(".")
    if dot:
        return {stage: {rest: value}}
    if name in STAGES:
        return {name: given(value) if isinstance(value, STAGES[name]) else value}
    homes = [stage for stage, table in STAGES.items() if name in _names(table)]
    if len(homes) == 1:
        return {homes[0]: {name: value}}
    if homes:
        known = " or ".join(f"{stage}={{...}}" for stage in homes)
        raise InputError(f"{name} is a setting of several stages; give it in {known}")
    every = [*STAGES, *(one for table in STAGES.values() for one in _names(table))]
    raise InputError(unknown(name, name, every))


def _names(table: Any) -> list[str]:
    return [field.name for field in fields(table)]
