"""The benchmark, topic by topic. Nothing in `recon` imports this."""

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
