"""The voxel map: cells that count their points, with mean position and colour.

The map is loaded when first used: figures need only the modules beside it, which compile nothing.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from recon.voxelmap.voxelmap import VoxelMap

__all__ = ["VoxelMap"]


def __getattr__(name: str) -> Any:
    if name != "VoxelMap":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from recon.voxelmap.voxelmap import VoxelMap

    return VoxelMap
