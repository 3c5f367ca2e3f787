"""Settings of surfaces: the fusion of depths, and what is left of it."""

from recon.settings.stage import Positive, table


@table
class SurfaceSettings:
    """Fusion of the depths of all pairs into one surface; `dense.enabled` asks for it."""

    voxel: Positive | None = None
    """Side of a voxel, world units; None = two pixels at the depths of the first pair."""
    mesh: bool = False
    """Leave a mesh besides the dense cloud."""
    watertight: bool = False
    """Close the mesh, by surface that nobody saw."""
    depth_maps: bool = False
    """Leave the depth map of each pair."""
