"""Frames of a recording, read one at a time; what cannot be used is skipped and counted."""

import copy
import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple, Protocol

from recon.errors import InputError
from recon.notices import notify
from recon.records import PairSource, StereoPair

log = logging.getLogger(__name__)


class Skipped(NamedTuple):
    """A frame that was left out, and why."""

    name: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frame:
    """One moment of a recording, its images not read yet."""

    name: str
    stamp_s: float
    load: Callable[[], StereoPair]
    """Reads and rectifies; an `InputError` leaves the frame out."""


class Frames(Protocol):
    """Frames in order; each pass begins anew."""

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[Frame]: ...

    def __getitem__(self, part: slice, /) -> "Frames": ...


class Recording:
    """A `PairSource` over frames that are read as they are asked for, never all in memory."""

    def __init__(
        self,
        frames: Frames,
        *,
        skipped: Iterable[Skipped] = (),
        unneeded: Iterable[Skipped] = (),
        disparity_range: tuple[int, int] | None = None,
    ) -> None:
        self.disparity_range = disparity_range
        """(min, max) in pixels, both included, where the recording tells; else None."""
        self._frames = frames
        self._unlisted = tuple(skipped)
        self._unneeded = tuple(unneeded)
        self._has_told = False
        self.skipped: list[Skipped] = [*self._unneeded, *self._unlisted]
        """Frames left out so far."""

    def __len__(self) -> int:
        """Pairs to be read at most."""
        return len(self._frames)

    def __getitem__(self, part: slice) -> "Recording":
        """A part of the frames; nothing of what lies before is read."""
        return Recording(self._frames[part], disparity_range=self.disparity_range)

    def __iter__(self) -> Iterator[StereoPair]:
        self.skipped = [*self._unneeded, *self._unlisted]
        last: Frame | None = None
        for frame in self._frames:
            try:
                _check_later(frame, last)
                pair = frame.load()
            except InputError as error:
                self.skipped.append(Skipped(frame.name, str(error)))
                log.info("frame %s is skipped: %s", frame.name, error)
                continue
            last = frame
            yield pair
        if last is None:
            raise InputError(f"no pair could be read; the first fault: {self._first_reason()}")
        self._say_skipped()

    def _say_skipped(self) -> None:
        """Tell once what a whole pass left out."""
        faulty = self.skipped[len(self._unneeded) :]
        if faulty and not self._has_told:
            self._has_told = True
            number, first = len(faulty), faulty[0]
            notify(
                "frames-skipped",
                f"{number} frame{'s' if number > 1 else ''} skipped; the first is {first.name}: "
                f"{first.reason}",
            )

    def _first_reason(self) -> str:
        return self.skipped[0].reason if self.skipped else "the sequence is empty"


Metrics = dict[str, float | list[float]]


class DerivedSource:
    """A `PairSource` that changes the pairs of another one as they come."""

    def __init__(self, source: PairSource) -> None:
        self.source = source
        self.disparity_range = source.disparity_range
        """(min, max) in pixels, both included, where the recording tells; else None."""

    @property
    def skipped(self) -> Sequence[tuple[str, str]]:
        """Frames left out so far."""
        return self.source.skipped

    @property
    def metrics(self) -> Metrics:
        """Numbers about the pairs given so far, by their names in metrics.json."""
        return self.source.metrics if isinstance(self.source, DerivedSource) else {}

    def __len__(self) -> int:
        return len(self.source)

    def __getitem__(self, part: slice) -> "DerivedSource":
        """A part of the pairs, changed as those of the whole are."""
        return self.over(self.source[part])

    def __iter__(self) -> Iterator[StereoPair]:
        return iter(self.source)

    def over(self, source: PairSource) -> "DerivedSource":
        """The same change of the pairs of another source."""
        changed = copy.copy(self)
        changed.source = source
        return changed


class PartOf(DerivedSource):
    """Some pairs of a source that has to go through all before them."""

    def __init__(self, source: PairSource, part: slice) -> None:
        super().__init__(source)
        self._rows = range(len(source))[part]

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, part: slice) -> "PartOf":
        rows = self._rows[part]
        return PartOf(self.source, slice(rows.start, rows.stop, rows.step))

    def __iter__(self) -> Iterator[StereoPair]:
        return islice(self.source, self._rows.start, self._rows.stop, self._rows.step)


def _check_later(frame: Frame, last: Frame | None) -> None:
    if last is not None and not frame.stamp_s > last.stamp_s:
        raise InputError(
            f"its time {frame.stamp_s:g} s is not after the {last.stamp_s:g} s of {last.name}"
        )
