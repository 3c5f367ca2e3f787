"""Settings of the voxel map."""

from typing import Annotated, Literal

from pydantic import Field

from recon.settings.stage import Count, NonNegative, Positive, Share, table

PartitionSize = Annotated[int, Field(ge=64, multiple_of=64)]
OccupancyRule = Literal["count", "weight", "carving", "log-odds", "views"]


@table
class MapSettings:
    """Cells, and when one counts as occupied (thesis 4.4)."""

    cell_size: Positive = 1.0
    """World units."""
    points: Literal["sparse", "dense"] = "sparse"
    """Points of the map: the matched features, or every pixel."""
    max_sigma: Positive | None = 1.4
    """Points less sure than this many cells count in coarser cells only; None = no limit."""
    occupancy: tuple[OccupancyRule, ...] = ("count",)
    """A cell is occupied where all of these rules hold."""
    min_count: Count = 5
    """Points that make a cell occupied; the thesis's CountThreshold."""
    min_weight: Positive = 2.0
    """Sum of the points' weights, 1 for a sure point, that makes a cell occupied."""
    min_hit_share: Share = 0.15
    """Carving: scans with a point in the cell for each that looked through it."""
    min_views: Count = 2
    """Distinct views with a point in the cell."""
    ray_margin: NonNegative = 1.5
    """Space is free up to so many cells before a point, or two sigma of it if that is more."""
    places: bool = False
    """Keep the places of a run, so that `recon localise` needs no recording."""
    partition_size: PartitionSize = 256
    """Cells along a side of a partition, where a map is made in chunks; a multiple of 64."""
