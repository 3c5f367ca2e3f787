"""Selectable occupancy rules; a cell is occupied if all selected rules hold."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.records import Voxels
from recon.settings import MapSettings
from recon.settings.mapping import OccupancyRule
from recon.voxelmap.rays import log_odds
from recon.voxelmap.table import Choose
from recon.voxelmap.voxelmap import VoxelMap

Mask = NDArray[np.bool_]


def enough_points(voxels: Voxels, settings: MapSettings) -> Mask:
    """The thesis's threshold on the count (section 4.4)."""
    return voxels.counts >= settings.min_count


def enough_weight(voxels: Voxels, settings: MapSettings) -> Mask:
    """Points weighted by sigma: many uncertain ones weigh no more than a few precise ones."""
    assert voxels.weights is not None
    return voxels.weights >= settings.min_weight


def not_carved(voxels: Voxels, settings: MapSettings) -> Mask:
    """Enough hits for the number of passing rays: ghosts due to noise are carved away."""
    assert voxels.hits is not None
    assert voxels.passes is not None
    return voxels.hits > settings.min_hit_share * voxels.passes


def more_likely_than_not(voxels: Voxels, settings: MapSettings) -> Mask:
    """OctoMap's log-odds of hits and passes, > 0."""
    assert voxels.hits is not None
    assert voxels.passes is not None
    return log_odds(voxels.hits, voxels.passes) > 0.0


def enough_views(voxels: Voxels, settings: MapSettings) -> Mask:
    """Enough different views: an error of one view is not repeated in another."""
    assert voxels.num_views is not None
    return voxels.num_views >= settings.min_views


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """A rule, and the channels it needs."""

    holds: Callable[[Voxels, MapSettings], Mask]
    channels: tuple[str, ...] = ()


RULES: dict[OccupancyRule, Rule] = {
    "count": Rule(holds=enough_points),
    "weight": Rule(holds=enough_weight, channels=("weight",)),
    "carving": Rule(holds=not_carved, channels=("rays",)),
    "log-odds": Rule(holds=more_likely_than_not, channels=("rays",)),
    "views": Rule(holds=enough_views, channels=("views",)),
}


def new_map(settings: MapSettings) -> VoxelMap:
    """An empty map with the channels that the rules of the settings need."""
    channels = {name for rule in settings.occupancy for name in RULES[rule].channels}
    return VoxelMap(settings.cell_size, channels=channels, ray_margin=settings.ray_margin)


def occupied(voxel_map: VoxelMap, settings: MapSettings, chosen: Choose | None = None) -> Voxels:
    """The cells for which every rule of the settings holds.

    Parameters
    ----------
    chosen : Callable, optional
        Mask (K,) of the cells to look at, by their indices (K, 3); all by default.

    Raises
    ------
    InputError
        If the map lacks a channel that a rule needs.
    """
    for rule in settings.occupancy:
        voxel_map.check_channels(RULES[rule].channels)
    is_counted = "count" in settings.occupancy
    voxels = voxel_map.occupied(settings.min_count if is_counted else 1, chosen)
    for rule in settings.occupancy:
        voxels = voxels.select(RULES[rule].holds(voxels, settings))
    return voxels
