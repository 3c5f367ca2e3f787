"""The record of a reader of recordings, for recon's own and those of plug-ins."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from recon.records import PairSource
from recon.settings import SequenceSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """One recording format: a test for a path, and a function that opens it.

    Plug-ins register such an object in the entry-point group `recon.sequences`.
    """

    fits: Callable[[Path], bool]
    """True if a path has this format, judged by its content."""
    open: Callable[[Path, SequenceSettings], PairSource]
    has_topics: bool = False
    """True if its images have topics, so that those given in the settings mean something."""
