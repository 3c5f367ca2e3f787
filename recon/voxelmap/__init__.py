"""The voxel map: cells that count their points, with mean position and colour."""

from recon.voxelmap.voxelmap import VoxelMap

__all__ = ["VoxelMap"]
