"""Plug-ins: parts by name, recon's own and those of installed packages, loaded when first used."""

import difflib
import importlib
import logging
from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Generic, TypeVar

from recon.errors import InputError

log = logging.getLogger(__name__)

Part = TypeVar("Part")


class Registry(Generic[Part]):
    """Parts of one kind, by name.

    Parameters
    ----------
    group : str
        Entry-point group in which installed packages offer parts of their own.
    noun : str
        Name of one part in messages: "matcher".
    own : mapping of str to str
        recon's own parts: name -> "module:object".
    """

    def __init__(self, group: str, noun: str, own: Mapping[str, str]) -> None:
        self.group = group
        self.noun = noun
        self._own = {name: EntryPoint(name, value, group) for name, value in own.items()}

    def __repr__(self) -> str:
        return f"Registry({self.group!r}: {', '.join(self.names())})"

    def names(self) -> list[str]:
        """Names of all parts, recon's own first; nothing is loaded."""
        return list(self._entries())

    def load(self, name: str) -> Part:
        """The part of that name.

        Raises
        ------
        InputError
            For a name that is not there, with the nearest one, and for a part that does not load.
        """
        self.check(name)
        return self._loaded(self._entries()[name])

    def check(self, name: str) -> None:
        """Raise `InputError` for a name that is not there, with the nearest one."""
        entries = self._entries()
        if name not in entries:
            known = ", ".join(sorted(entries))
            near = difflib.get_close_matches(name, entries, n=1, cutoff=0.0)
            nearest = f" (nearest: {near[0]})" if near else ""
            raise InputError(f"{self.noun} is {name!r}, but one of {known} is needed{nearest}")

    def parts(self) -> Iterator[tuple[str, Part]]:
        """Every part that loads, with its name; one that does not is named in one warning."""
        for name, entry in self._entries().items():
            try:
                part = self._loaded(entry)
            except InputError as error:
                log.warning("%s; it is left out", error)
            else:
                yield name, part

    def _entries(self) -> dict[str, EntryPoint]:
        """All entry points by name; no plug-in replaces a part of recon."""
        plugins = {entry.name: entry for entry in entry_points(group=self.group)}
        return self._own | {name: one for name, one in plugins.items() if name not in self._own}

    def _loaded(self, entry: EntryPoint) -> Part:
        try:
            part: Part = getattr(importlib.import_module(entry.module), entry.attr)
        # A package of somebody else's may fail in any way.
        except Exception as error:
            raise InputError(
                f"{self.noun} {entry.name!r} ({entry.value}) does not load: "
                f"{type(error).__name__}: {error}"
            ) from error
        return part
