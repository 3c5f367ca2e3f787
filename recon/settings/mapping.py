"""Settings of the voxel map."""

from pydantic.dataclasses import dataclass

from recon.settings.stage import STRICT, Count, Positive


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MapSettings:
    """Cells, and when one counts as occupied (thesis 4.4)."""

    cell_size: Positive = 1.0
    """World units."""
    min_count: Count = 5
    """Points that make a cell occupied; the thesis's CountThreshold."""
    max_sigma: Positive | None = 1.0
    """Points less sure than this many cells are used to detect things, but not for the map."""
