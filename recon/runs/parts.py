"""A part of a recording as a separate job: one pair of overlap, numbered as in the whole."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from recon.errors import InputError
from recon.mapping.mapper import Part
from recon.records import StereoPair
from recon.runs.job import Job
from recon.sequences.frames import DerivedSource
from recon.sequences.open import open_sequence
from recon.sequences.refined import Refined, read_refined, refine
from recon.settings import SequenceSettings, Settings
from recon.surface.confirmation import NUM_NEIGHBOURS


class PartialSource(DerivedSource):
    """Some pairs of a recording, and neighbouring pairs that only confirm.

    Parameters
    ----------
    whole : DerivedSource
    start, stop : int
        The pairs that count.
    overlap : int
        Pairs before and after them that only confirm, if readable.
    """

    def __init__(self, whole: DerivedSource, start: int, stop: int, overlap: int) -> None:
        is_all = (start, stop) == (0, len(whole))
        super().__init__(whole if is_all else whole[start:stop])
        self._before = whole[max(start - overlap, 0) : start]
        self._after = whole[stop : stop + overlap]
        self._first = start - len(self._before)
        self._is_own: list[bool] = []

    @property
    def numbers(self) -> Part:
        """Numbers of the pairs read so far, and which of them count."""
        return Part(first=self._first, counts=lambda number: self._is_own[number - self._first])

    def __iter__(self) -> Iterator[StereoPair]:
        self._is_own = []
        for source in (self._before, self.source, self._after):
            try:
                for pair in source if len(source) else ():
                    self._is_own.append(source is self.source)
                    yield pair
            except InputError:
                if source is self.source:
                    raise


def part_of(job: Job, whole: DerivedSource) -> PartialSource:
    """The part of a recording that a job processes; by default all pairs.

    If points or depths have to be confirmed, pairs before and after the part are read, too.

    Raises
    ------
    InputError
        If the part lies beyond the recording.
    """
    start, stop = job.arguments.get("part", (0, len(whole)))
    if stop > len(whole):
        raise InputError(f"part ends at {stop}, but the recording has {len(whole)} pairs")
    return PartialSource(whole, start, stop, _overlap(job.settings))


def _overlap(settings: Settings) -> int:
    """Number of pairs before and after a part that confirm it."""
    if settings.wants_surface:
        return NUM_NEIGHBOURS
    return 1 if settings.sequence.only_confirmed else 0


def refined_of(job: Job) -> Refined | None:
    """The job's given record of the recording; None if it makes its own estimates."""
    path = job.arguments.get("refined")
    return None if path is None else read_refined(path)


def without_poses(refined: Refined | None) -> Refined | None:
    """The record for pairs whose poses do not matter."""
    return None if refined is None else replace(refined, poses={})


def write_refined(recording: Path, settings: SequenceSettings, target: Path) -> int:
    """Write the estimates that all parts of a recording need; return the number of its pairs."""
    source = open_sequence(recording, settings)
    refine(source).write(target)
    return len(source)
