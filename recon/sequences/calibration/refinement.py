"""Correction of the residual of an imperfect rectification.

A row offset of a third of a pixel costs a matcher a fifth of its points.
"""

import logging
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from functools import cached_property
from itertools import islice

import cv2

from recon.camera import StereoRig
from recon.errors import InputError
from recon.records import PairSource, StereoPair
from recon.sequences.calibration.row_error import Maps, Residual
from recon.sequences.calibration.selfcalibration import estimate_residual, estimate_row_residual
from recon.sequences.frames import DerivedSource, Metrics
from recon.sequences.odometry.tracking import Tracks, sight, track
from recon.threads import in_threads

log = logging.getLogger(__name__)

NUM_ROW_PAIRS = 10
"""Number of first pairs used to estimate the row offset, which needs no motion."""
MAX_TRACKED_PAIRS = 30
"""Number of pairs used to estimate the disparity offset, evenly spread over the recording."""


class RefinedPairs(DerivedSource):
    """The pairs of a source with their right images resampled if the images require it."""

    def __init__(self, source: PairSource, estimate: Callable[[PairSource], Residual]) -> None:
        super().__init__(source)
        self._whole = source  # a part of the pairs is corrected like the whole
        self._estimate = estimate

    @cached_property
    def residual(self) -> Residual:
        """The residual removed; estimated by a separate pass at first access."""
        residual = self._estimate(self._whole)
        for name, field in (("rows", residual.row), ("disparities", residual.disparity)):
            if field.coefficients.any():
                log.info(
                    "%s are off by %s px (of 1, x, y, x^2, xy, y^2 across the image); corrected",
                    name,
                    field.coefficients.round(2).tolist(),
                )
        return residual

    @property
    def metrics(self) -> Metrics:
        """The residual removed from rows and disparities, as the coefficients of `Field`."""
        return super().metrics | {
            "row_residual_px": self.residual.row.coefficients.round(4).tolist(),
            "disparity_residual_px": self.residual.disparity.coefficients.round(4).tolist(),
        }

    def __iter__(self) -> Iterator[StereoPair]:
        # Do other passes first: a source counts its skipped frames in one pass at a time.
        maps = self.residual.maps(next(iter(self.source)).rig)
        for pair in self.source:
            yield pair if maps is None else _resampled(pair, maps)


def _resampled(pair: StereoPair, maps: Maps) -> StereoPair:
    right = cv2.remap(pair.right, *maps, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return replace(pair, right=right)


_estimates: ContextVar[dict[Hashable, Residual] | None] = ContextVar("estimates", default=None)


@contextmanager
def shared_estimates() -> Iterator[None]:
    """Estimate the rows of a recording once, however often it is opened inside the block."""
    token = _estimates.set({})
    try:
        yield
    finally:
        _estimates.reset(token)


def shared_row_residual(recording: Hashable, source: PairSource) -> Residual:
    """`row_residual` of a recording, estimated by the first of the sources that read it."""
    known = _estimates.get()
    if known is None:
        return row_residual(source)
    if recording not in known:
        known[recording] = row_residual(source)
    return known[recording]


def row_residual(source: PairSource) -> Residual:
    """Residual of rows in the first pairs; zero if their rigs differ."""
    rigs: list[StereoRig] = []

    def alike() -> Iterator[StereoPair]:
        """The pairs up to one of another rig."""
        for pair in islice(source, NUM_ROW_PAIRS):
            rigs.append(pair.rig)
            if pair.rig != rigs[0]:
                return
            yield pair

    seen = [*in_threads(sight, alike())]
    return estimate_row_residual(seen, rigs[0]) if len(seen) == len(rigs) else Residual()


def full_residual(source: PairSource) -> Residual:
    """Residual of rows and disparities, from tracks between pairs throughout a recording.

    Raises
    ------
    InputError
        If the pairs are not all of the same rig, as in a ring.
    """
    pairs = iter(source)
    first = next(pairs)
    rig = first.rig
    tracks: list[Tracks] = []
    stride = -(-len(source) // MAX_TRACKED_PAIRS)
    for number, second in enumerate(pairs):
        if second.rig != rig:
            raise InputError(
                f"{second.name} has a different rig than {first.name}, but poses are estimated "
                "for one moving rig"
            )
        if number % stride == 0:
            tracks.append(track(first, second))
        first = second
    return estimate_residual(tracks, rig)
