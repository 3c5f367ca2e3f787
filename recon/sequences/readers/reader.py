"""The record of a reader of recordings, of recon's own and those of plug-ins."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from recon.records import PairSource
from recon.settings import SequenceSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """One form of recording: a test whether a path holds it, and a function that opens it.

    Plug-ins name an object of this kind in the entry-point group `recon.sequences`.
    """

    fits: Callable[[Path], bool]
    """True where a path holds this form, told by what is in it."""
    open: Callable[[Path, SequenceSettings], PairSource]
