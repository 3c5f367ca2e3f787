"""The share of triangulated points that reached a cell of the map, and the image noise."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from recon.mapping.pair import PairResult
from recon.notices import notify

LEAST_SHARE = 0.85
"""A smaller share of mapped points causes a notice."""


@dataclass(slots=True, kw_only=True)
class Reached:
    """Counts over all pairs so far."""

    num_triangulated: int = 0
    num_mapped: int = 0
    _noises: list[tuple[float, float]] = field(default_factory=list)

    def see(self, result: PairResult) -> None:
        """Add the counts of a pair."""
        self.num_triangulated += len(result.cloud) + len(result.doubtful)
        self._noises.append(result.image_noise)

    @property
    def share(self) -> float | None:
        """Share of the points with a finite depth that reached a cell; None if there are none."""
        return self.num_mapped / self.num_triangulated if self.num_triangulated else None

    @property
    def metrics(self) -> dict[str, Any]:
        """`map_share` and `image_noise`, the median over the pairs in grey levels."""
        noise = np.median(self._noises, axis=0).tolist() if self._noises else None
        return {"map_share": self.share, "image_noise": noise}

    def say(self) -> None:
        """Notify if a large share of the points reached no cell."""
        if self.share is not None and self.share < LEAST_SHARE:
            left_out = self.num_triangulated - self.num_mapped
            notify(
                "points-left-out",
                f"{left_out} of {self.num_triangulated} points are too uncertain for the map: "
                "make map.cell_size or map.max_sigma larger, or set map.max_sigma to none",
            )
