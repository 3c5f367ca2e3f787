"""Settings as TOML, and overrides by name."""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, fields
from typing import Any, get_args, get_type_hints

import tomli_w
from pydantic import ValidationError

from recon.errors import InputError, nearest, unknown
from recon.settings.stage import first_fault, given
from recon.settings.stages import S, Stages
from recon.settings.world import FOLLOWERS

Tree = dict[str, dict[str, Any]]

STAGES: dict[str, Any] = {
    field.name: type(getattr(Stages(), field.name)) for field in fields(Stages)
}
"""The table of each stage, by its name."""
OPTIONS = ("preset", "quality", "seed")
"""Options that belong to no stage: each sets many settings, or none."""


def to_tree(settings: Stages) -> Tree:
    """All values by stage and name; None is the word "none", as TOML has no None."""
    return {
        stage: {name: "none" if value is None else value for name, value in values.items()}
        for stage, values in asdict(settings).items()
    }


def to_toml(settings: Stages) -> str:
    """The text of `settings.toml`."""
    return tomli_w.dumps(to_tree(settings))


def parse_overrides(overrides: Iterable[str]) -> dict[str, Any]:
    """Values by "stage.name" from lines "stage.name=value", the value in TOML or a bare word."""
    values: dict[str, Any] = {}
    for line in overrides:
        key, equals, text = line.partition("=")
        if not (equals and key.strip()):
            raise InputError(f"--set is {line!r}, but stage.name=value is needed")
        values[key.strip()] = _value(text.strip())
    return values


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def given_tree(settings: Stages) -> Tree:
    """The explicitly given values, by stage and name, without defaults."""
    return {stage: given(getattr(settings, stage)) for stage in STAGES}


def merged(*given: Mapping[str, Any]) -> Tree:
    """Tables by stage from values by "stage.name" or tables; later ones take precedence."""
    tree: dict[str, Any] = {}
    for key, value in (pair for values in given for pair in values.items()):
        stage, dot, name = key.partition(".")
        table = {name: value} if dot else value
        is_joined = isinstance(table, Mapping) and isinstance(tree.get(stage), Mapping)
        tree[stage] = {**tree[stage], **table} if is_joined else table
    return tree


def updated(settings: S, changes: Mapping[str, Any], source: str = "settings") -> S:
    """`settings` with the values of `changes`, all of them checked; the word "none" is None.

    Parameters
    ----------
    changes : mapping
        Values by "stage.name", or in tables by stage.
    source : str
        What errors name as their place.

    Raises
    ------
    InputError
        For an unknown name, with the nearest known one, and for a value out of its range.
    """
    stages = {stage: getattr(settings, stage) for stage in STAGES}
    for stage, values in merged(changes).items():
        if stage not in STAGES:
            raise InputError(_unknown_stage(stage, source))
        if not isinstance(values, Mapping):
            raise InputError(f"{source}: {stage} is {values!r}, but a table is needed")
        known = [f"{stage}.{known.name}" for known in fields(STAGES[stage])]
        for name in values:
            _check_known(f"{stage}.{name}", known, source)
        plain = {name: _plain(stage, name, value) for name, value in values.items()}
        stages[stage] = _changed(stage, given(stages[stage]), plain, source)
    return type(settings)(**stages)


def _plain(stage: str, name: str, value: Any) -> Any:
    """The value, None for the word "none" where the setting may be None."""
    if value != "none":
        return value
    kind = get_type_hints(STAGES[stage], include_extras=True)[name]
    return None if type(None) in get_args(kind) else value


def _unknown_stage(name: str, source: str) -> str:
    """The message about an unknown stage, which may be an option, or a setting without a stage."""
    if name in OPTIONS:
        return (
            f"{source}: {name} is not a setting: it is the option --{name}, and in a job file "
            "a key of the job"
        )
    settings = {
        one.name: f"{stage}.{one.name}" for stage in STAGES for one in fields(STAGES[stage])
    }
    known = settings | dict.fromkeys(STAGES)
    found = nearest(name, known)
    return f"{source}: {name} is unknown; the nearest known name is {known[found] or found}"


def _check_known(name: str, known: Iterable[str], source: str) -> None:
    known = list(known)
    if name not in known:
        raise InputError(unknown(f"{source}: {name}", name, known))


def _changed(stage: str, before: dict[str, Any], changes: dict[str, Any], source: str) -> Any:
    """A stage's table with its given values and their changes; what follows from one, does."""
    followers = {FOLLOWERS[name] for name in changes if name in FOLLOWERS} - set(changes)
    kept = {name: value for name, value in before.items() if name not in followers}
    try:
        return STAGES[stage](**kept | changes)
    except InputError as error:
        fault = error.__cause__
        assert isinstance(fault, ValidationError)
        raise InputError(f"{source}: {first_fault(fault, stage)}") from error
