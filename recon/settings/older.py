"""Settings written by an older version of recon."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from recon.errors import InputError
from recon.settings.files import STAGES, updated
from recon.settings.settings import Settings


def tolerated(changes: Mapping[str, Any]) -> tuple[Settings, tuple[str, ...]]:
    """Settings written by an older version, and the names of those no longer understood.

    A setting that is unknown today, or whose value is out of today's range, keeps its default.
    """
    tables = {
        stage: values if isinstance(values, Mapping) else {} for stage, values in changes.items()
    }
    names = {stage: {one.name for one in fields(STAGES[stage])} for stage in STAGES}
    given_names = [(stage, name) for stage, table in tables.items() for name in table]
    ignored = [pair for pair in given_names if pair[1] not in names.get(pair[0], ())]
    kept = [pair for pair in given_names if pair not in ignored]
    settings = Settings()
    # Twice: a value may be in range only in combination with a later one.
    for _ in range(2):
        refused = []
        for stage, name in kept:
            try:
                settings = updated(settings, {stage: {name: tables[stage][name]}})
            except InputError:
                refused.append((stage, name))
    return settings, tuple(".".join(pair) for pair in ignored + refused)
