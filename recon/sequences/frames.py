"""Frames of a recording, read one at a time; unusable ones are skipped and counted."""

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
    """A skipped frame, and the reason."""

    name: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frame:
    """One frame of a recording, with its images not yet loaded."""

    name: str
    stamp_s: float
    load: Callable[[], StereoPair]
    """Reads and rectifies; the frame is skipped on `InputError`."""


class Frames(Protocol):
    """Frames in order; each iteration starts from the beginning."""

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[Frame]: ...

    def __getitem__(self, part: slice, /) -> "Frames": ...


class Recording:
    """A `PairSource` over frames that are read on demand, never all in memory."""

    def __init__(
        self,
        frames: Frames,
        *,
        skipped: Iterable[Skipped] = (),
        unneeded: Iterable[Skipped] = (),
        disparity_range: tuple[int, int] | None = None,
    ) -> None:
        self.disparity_range = disparity_range
        """(min, max) in pixels, both included, if the recording states it; else None."""
        self._frames = frames
        self._unlisted = tuple(skipped)
        self._unneeded = tuple(unneeded)
        self._has_told = False
        self.skipped: list[Skipped] = [*self._unneeded, *self._unlisted]
        """Frames skipped so far."""

    def __len__(self) -> int:
        """Maximum number of pairs."""
        return len(self._frames)

    def __getitem__(self, part: slice) -> "Recording":
        """A part of the frames; earlier frames are not read."""
        check_slice(part)
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
            raise InputError(f"no pair could be read; {self._first_reason()}")
        self._say_skipped()

    def _say_skipped(self) -> None:
        """Report once the frames skipped by a complete pass."""
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
        if not self.skipped:
            return "the sequence is empty"
        return "the first is {}: {}".format(*self.skipped[0])


Metrics = dict[str, float | list[float]]


class DerivedSource:
    """A `PairSource` that modifies the pairs of another one."""

    def __init__(self, source: PairSource) -> None:
        self.source = source
        self.disparity_range = source.disparity_range
        """(min, max) in pixels, both included, if the recording states it; else None."""

    @property
    def skipped(self) -> Sequence[tuple[str, str]]:
        """Frames skipped so far."""
        return self.source.skipped

    @property
    def metrics(self) -> Metrics:
        """Metrics of the pairs so far, by their names in metrics.json."""
        return self.source.metrics if isinstance(self.source, DerivedSource) else {}

    def __len__(self) -> int:
        return len(self.source)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self)} pairs)"

    def __getitem__(self, part: slice) -> "DerivedSource":
        """A part of the pairs, modified like the whole."""
        check_slice(part)
        return self.over(self.source[part])

    def __iter__(self) -> Iterator[StereoPair]:
        return iter(self.source)

    def over(self, source: PairSource) -> "DerivedSource":
        """The same modification applied to another source."""
        changed = copy.copy(self)
        changed.source = source
        return changed


class PartOf(DerivedSource):
    """Some pairs of a source that must process all pairs before them."""

    def __init__(self, source: PairSource, part: slice) -> None:
        super().__init__(source)
        self._rows = range(len(source))[part]

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, part: slice) -> "PartOf":
        check_slice(part)
        rows = self._rows[part]
        return PartOf(self.source, slice(rows.start, rows.stop, rows.step))

    def __iter__(self) -> Iterator[StereoPair]:
        return islice(self.source, self._rows.start, self._rows.stop, self._rows.step)


def check_slice(part: object) -> None:
    """Raise `InputError` for a single number, whose pair may be skipped, and for a way back."""
    if not isinstance(part, slice) or (part.step is not None and part.step < 1):
        raise InputError(f"the index of a recording is {part!r}, but a slice such as 0:9 is needed")


def _check_later(frame: Frame, last: Frame | None) -> None:
    if last is not None and not frame.stamp_s > last.stamp_s:
        raise InputError(
            f"its time {frame.stamp_s:g} s is not after the {last.stamp_s:g} s of {last.name}"
        )
