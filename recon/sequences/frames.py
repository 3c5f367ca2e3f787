"""Frames of a recording, read one at a time; what cannot be used is skipped and counted."""

import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from recon.errors import InputError
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


class Recording:
    """A `PairSource` over frames that are read as they are asked for, never all in memory."""

    def __init__(
        self,
        frames: Frames,
        *,
        skipped: Iterable[Skipped] = (),
        disparity_range: tuple[int, int] | None = None,
    ) -> None:
        self.disparity_range = disparity_range
        """(min, max) in pixels, both included, where the recording tells; else None."""
        self._frames = frames
        self._unlisted = tuple(skipped)
        self._told: set[str] = set()
        self.skipped: list[Skipped] = []
        """What was left out, so far."""
        self._begin()

    def __len__(self) -> int:
        """Pairs to be read at most."""
        return len(self._frames)

    def __iter__(self) -> Iterator[StereoPair]:
        self._begin()
        last: Frame | None = None
        for frame in self._frames:
            try:
                _check_later(frame, last)
                pair = frame.load()
            except InputError as error:
                self._skip(frame.name, str(error))
                continue
            last = frame
            yield pair
        if last is None:
            raise InputError(f"no pair could be read; the first fault: {self._first_reason()}")

    def _begin(self) -> None:
        self.skipped = []
        for name, reason in self._unlisted:
            self._skip(name, reason)

    def _skip(self, name: str, reason: str) -> None:
        self.skipped.append(Skipped(name, reason))
        if name not in self._told:
            self._told.add(name)
            log.warning("frame %s is skipped: %s", name, reason)

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
        """What was left out, so far."""
        return self.source.skipped

    @property
    def metrics(self) -> Metrics:
        """Numbers about the pairs given so far, by their names in metrics.json."""
        return self.source.metrics if isinstance(self.source, DerivedSource) else {}

    def __len__(self) -> int:
        return len(self.source)

    def __iter__(self) -> Iterator[StereoPair]:
        return iter(self.source)


def _check_later(frame: Frame, last: Frame | None) -> None:
    if last is not None and not frame.stamp_s > last.stamp_s:
        raise InputError(
            f"its time {frame.stamp_s:g} s is not after the {last.stamp_s:g} s of {last.name}"
        )
