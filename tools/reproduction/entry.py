"""Entries of the page: the thesis's result, recon's result, and why they differ."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from matplotlib.figure import Figure

Row = tuple[str, ...]


class Absent(Exception):
    """Requirements of an entry are missing; the page shows the reason."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A small table."""

    head: Row
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """The result of recon for an entry."""

    figures: tuple[Figure, ...] = ()
    images: tuple[Path, ...] = ()
    """Images that lie in files already."""
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One figure or table of the thesis."""

    name: str
    """"figure 12", "table 3"."""
    title: str
    thesis: str
    """The statement of the thesis, in a sentence, with its numbers."""
    difference: str
    """Why recon's differs, in a sentence."""
    make: Callable[[], Result] = field(repr=False)

    @property
    def slug(self) -> str:
        """Convert a name for use in file names."""
        return self.name.replace(" ", "_").replace(",", "")


def number(value: float | None, digits: int = 1) -> str:
    """Format a number of a table; a dash for None."""
    return "-" if value is None else f"{value:.{digits}f}"


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> Table:
    """Make a table of any values."""
    return Table(head=tuple(head), rows=tuple(tuple(str(c) for c in row) for row in rows))
