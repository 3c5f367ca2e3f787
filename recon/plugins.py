"""Plug-ins by name, recon's own and those of installed packages, loaded when first used."""

import functools
import logging
from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from recon.errors import InputError, check_type, nearest

log = logging.getLogger(__name__)

Part = TypeVar("Part")

GROUPS = (
    "controllers", "matchers", "sequences", "formats", "figures", "recognisers", "renderers",
    "jobs",
)  # fmt: skip
"""Kinds of plug-ins; each is the entry-point group `recon.NAME`."""

_registered: dict[str, dict[str, Any]] = {}
"""Plug-ins registered by this process, by entry-point group and name."""


def register(group: str, name: str, part: Any) -> None:
    """Register a plug-in by name in this process, as if it were installed.

    Parameters
    ----------
    group : str
        One of controllers, matchers, sequences, formats, figures, recognisers, renderers, jobs.
    name : str
        The name by which it is requested; recon's own names cannot be replaced.
    part : object
        The object described on the group's page in docs/plugin.

    Raises
    ------
    InputError
        For an unknown group, or a name that is not text.
    """
    check_type("name", name, str)
    if group not in GROUPS:
        raise InputError(f"group is {group!r}, but one of {', '.join(GROUPS)} is needed")
    _registered.setdefault(f"recon.{group}", {})[name] = part


@functools.cache
def say_once(fault: str) -> None:
    """Warn of a plug-in's fault, once per process."""
    log.warning("%s", fault)


class Registry(Generic[Part]):
    """Plug-ins of one kind, by name.

    Parameters
    ----------
    group : str
        Entry-point group in which installed packages register their plug-ins.
    noun : str
        Name of one plug-in in messages: "matcher".
    own : mapping of str to str
        recon's own plug-ins: name -> "module:object".
    """

    def __init__(self, group: str, noun: str, own: Mapping[str, str]) -> None:
        self.group = group
        self.noun = noun
        self._own = {name: EntryPoint(name, value, group) for name, value in own.items()}

    def __repr__(self) -> str:
        return f"Registry({self.group!r}: {', '.join(self.names())})"

    def names(self) -> list[str]:
        """Names of all plug-ins, recon's own first; nothing is loaded."""
        return list(self._entries())

    def load(self, name: str) -> Part:
        """The plug-in of that name.

        Raises
        ------
        InputError
            For an unknown name, with the nearest known one, and for a plug-in that does not load.
        """
        # Scanning all installed packages is slow; recon's own plug-ins need not wait for it.
        if name in self._own:
            if name in _registered.get(self.group, ()):
                say_once(f"{self.noun} {name!r} is recon's own; the registered one is not used")
            return self._loaded(self._own[name])
        self.check(name)
        return self._part(name, self._entries())

    def __contains__(self, name: object) -> bool:
        return name in self._own or name in self._entries()

    def check(self, name: str) -> None:
        """Raise `InputError` for an unknown name, with the nearest known one."""
        if name not in self:
            entries = self._entries()
            known = ", ".join(sorted(entries))
            near = f" (nearest: {nearest(name, entries)})" if entries else ""
            raise InputError(f"{self.noun} is {name!r}, but one of {known} is needed{near}")

    def parts(self) -> Iterator[tuple[str, Part]]:
        """Every plug-in that loads, with its name; one that does not is reported once."""
        entries = self._entries()
        for name in entries:
            try:
                part = self._part(name, entries)
            except InputError as error:
                say_once(f"{error}; it is skipped")
            else:
                yield name, part

    def _entries(self) -> dict[str, EntryPoint | None]:
        """All entry points by name, None for registered plug-ins; recon's own take precedence."""
        plugins = {entry.name: entry for entry in entry_points(group=self.group)}
        registered = dict.fromkeys(_registered.get(self.group, ()))
        return {**self._own, **(plugins | registered), **self._own}

    def _part(self, name: str, entries: Mapping[str, EntryPoint | None]) -> Part:
        entry = entries[name]
        if entry is not None:
            return self._loaded(entry)
        part: Part = _registered[self.group][name]
        return part

    def _loaded(self, entry: EntryPoint) -> Part:
        try:
            part: Part = entry.load()
        # A third-party package may fail in any way.
        except Exception as error:
            raise InputError(
                f"{self.noun} {entry.name!r} ({entry.value}) does not load: "
                f"{type(error).__name__}: {error}"
            ) from error
        return part
