"""The one stateful store: cells that count the points in them, their mean place and colour."""

from recon.voxelmap.voxelmap import VoxelMap

__all__ = ["VoxelMap"]
