"""Settings of the voxel map."""

from typing import Annotated, Literal

from pydantic import Field

from recon.settings.stage import Count, NonNegative, Positive, Share, table

PartitionSize = Annotated[int, Field(ge=64, multiple_of=64)]
OccupancyRule = Literal["count", "weight", "carving", "log-odds", "views"]


@table
class MapSettings:
    """The cells of the map, and when a cell counts as occupied (thesis 4.4)."""

    cell_size: Positive = 1.0
    """Side of a cell, world units."""
    points: Literal["sparse", "dense"] = "sparse"
    """Points that go into the map: matched features, or every pixel."""
    max_sigma: Positive | None = 1.4
    """Largest sigma of a point, cells; points above it count in coarser cells only; none = no
    limit."""
    occupancy: tuple[OccupancyRule, ...] = ("count",)
    """Rules of occupancy; a cell is occupied if all of them hold."""
    min_count: Count = 5
    """Smallest number of points in an occupied cell; the thesis's CountThreshold."""
    min_weight: Positive = 2.0
    """Smallest sum of point weights in an occupied cell; a certain point weighs 1."""
    min_hit_share: Share = 0.15
    """Rule `carving`: smallest share of the scans through a cell that have a point in it."""
    min_views: Count = 2
    """Rule `views`: smallest number of distinct views with a point in the cell."""
    ray_margin: NonNegative = 1.5
    """Distance before a point up to which space counts as free, cells; at least two sigma of the
    point."""
    places: bool = False
    """Save descriptions of the places of a run, so that `recon localise` needs no recording."""
    partition_size: PartitionSize = 256
    """Side of a partition of a map built in chunks, cells; a multiple of 64."""
