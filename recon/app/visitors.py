"""State per visitor, kept while the page is closed and found again by a cookie."""

from collections import OrderedDict
from collections.abc import Callable
from typing import Generic, TypeVar

from recon.libraries import load_extra

Kept = TypeVar("Kept")

MOST = 16
"""Maximum number of visitors whose state is kept; the oldest is dropped first."""


class Visitors(Generic[Kept]):
    """One object per visitor, created at the first visit."""

    def __init__(self, make: Callable[[], Kept]) -> None:
        self._make = make
        self._kept: OrderedDict[str, Kept] = OrderedDict()

    def current(self) -> Kept:
        """The object of the current visitor."""
        name = str(load_extra("nicegui", "app").app.storage.browser["id"])
        if name not in self._kept:
            self._kept[name] = self._make()
            while len(self._kept) > MOST:
                self._kept.popitem(last=False)
        self._kept.move_to_end(name)
        return self._kept[name]
