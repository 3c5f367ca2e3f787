"""Belongings of visitors, kept while the page is away: a cookie finds them again."""

from collections import OrderedDict
from collections.abc import Callable
from typing import Generic, TypeVar

from recon.libraries import load_extra

Kept = TypeVar("Kept")

MOST = 16
"""Visitors whose things are kept; who came first goes first."""


class Visitors(Generic[Kept]):
    """One thing per visitor, made at the first visit."""

    def __init__(self, make: Callable[[], Kept]) -> None:
        self._make = make
        self._kept: OrderedDict[str, Kept] = OrderedDict()

    def current(self) -> Kept:
        """The thing of whoever opens the page now."""
        name = str(load_extra("nicegui", "app").app.storage.browser["id"])
        if name not in self._kept:
            self._kept[name] = self._make()
            while len(self._kept) > MOST:
                self._kept.popitem(last=False)
        self._kept.move_to_end(name)
        return self._kept[name]
