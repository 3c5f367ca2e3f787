"""The benchmark, topic by topic. Nothing in `recon` imports this."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """One measured number of a topic."""

    name: str
    """Unique, as "stereo.best_741x500_ratio"."""
    value: float
    unit: str
    """"of StereoSGBM's time", "percent", "bytes/cell", ..."""
    better: Literal["lower", "higher"]
    tolerance: float
    """Share of the baseline by which it may fall behind."""


def cpu_seconds(work: Callable[[], object]) -> float:
    """Measure the CPU time of a call, of all its threads."""
    began = time.process_time()
    work()
    return time.process_time() - began


def least_cpu_seconds(work: Callable[[], object], repeats: int) -> float:
    """Measure the least CPU time of some calls."""
    return min(cpu_seconds(work) for _ in range(repeats))
