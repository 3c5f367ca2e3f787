"""Poses of a recording without any: stereo visual odometry, scale from the baseline."""

import logging
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from recon.geometry import invert
from recon.notices import notify
from recon.records import PairSource, StereoPair
from recon.sequences.calibration.refinement import RefinedPairs, full_residual
from recon.sequences.calibration.row_error import Residual
from recon.sequences.frames import DerivedSource, Metrics, PartOf, check_slice
from recon.sequences.odometry.errors import drift_percent
from recon.sequences.odometry.motion import estimate_motion
from recon.sequences.odometry.tracking import track
from recon.sequences.poses import T_up_recorded

Array = NDArray[np.float64]

log = logging.getLogger(__name__)


class EstimatedPoses(DerivedSource):
    """A `PairSource` of pairs with estimated poses and corrected rectification.

    The world is the first left camera's frame, rotated so that y is up. The source's own poses
    serve to measure the drift.
    """

    def __init__(self, source: PairSource) -> None:
        self._straight = RefinedPairs(source, full_residual)
        super().__init__(self._straight)
        self.carried: list[str] = []
        """Names of the frames so far that could not be tracked: they repeat the last motion."""
        self._estimated: list[Array] = []
        self._true: list[Array | None] = []

    @property
    def residual(self) -> Residual:
        """Residual of rows and disparities, estimated from the images and removed in the pairs."""
        return self._straight.residual

    def __getitem__(self, part: slice) -> PartOf:
        """A part of the pairs; their poses continue from the first pair of all."""
        check_slice(part)
        return PartOf(self, part)

    def __iter__(self) -> Iterator[StereoPair]:
        self.carried, self._estimated, self._true = [], [], []
        T_world_left = T_up_recorded(np.eye(4))
        T_first_second = np.eye(4)
        last: StereoPair | None = None
        for pair in self._straight:
            if last is not None:
                T_first_second = self._motion(last, pair, T_first_second)
                T_world_left = T_world_left @ T_first_second
            self._estimated.append(T_world_left)
            self._true.append(pair.T_world_left)
            yield replace(pair, T_world_left=T_world_left)
            last = pair
        if self.carried:
            notify(
                "frames-carried",
                f"{len(self.carried)} of {len(self._estimated)} frames could not be tracked, and "
                f"repeat the previous motion; the first is {self.carried[0]}",
            )

    @property
    def metrics(self) -> Metrics:
        """Metrics of the source, number of untracked frames, and drift if true poses are known."""
        numbers = super().metrics | {"num_carried": len(self.carried)}
        drift = self.drift_percent_of(self._estimated)
        return numbers if drift is None else numbers | {"drift_percent": drift}

    def drift_percent_of(self, poses: Sequence[Array]) -> float | None:
        """The drift of poses (N, 4, 4) of the pairs so far; None without true poses."""
        both = [(e, t) for e, t in zip(poses, self._true, strict=True) if t is not None]
        if len(both) < 2:
            return None
        estimated, true = np.array(both).swapaxes(0, 1)
        return drift_percent(estimated, true)

    def _motion(self, first: StereoPair, second: StereoPair, usual: Array) -> Array:
        """`T_first_second` (4, 4); `usual` if too little can be tracked."""
        T_second_first = estimate_motion(track(first, second), first.rig)
        if T_second_first is not None:
            return invert(T_second_first)
        log.info("frame %s could not be tracked: the last motion is repeated", second.name)
        self.carried.append(second.name)
        return usual
