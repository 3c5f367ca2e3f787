"""Figures 22 to 24: the simulator in a browser, as screenshots."""

from collections.abc import Iterator

from reproduction.entry import Entry


def entries() -> Iterator[Entry]:
    """The entries of this part."""
    yield from ()
