"""Settings of surfaces: the fusion of depths, and what is left of it."""

from recon.settings.stage import Positive, table


@table
class SurfaceSettings:
    """How the depths of all pairs become one surface; `dense.enabled` asks for it."""

    voxel: Positive | None = None
    """Side of a voxel, world units; None = two pixels at the depths of the first pair."""
    mesh: bool = False
    """Whether a mesh is left besides the dense cloud."""
    watertight: bool = False
    """Whether the mesh is closed, by surface that nobody saw."""
    depth_maps: bool = False
    """Whether the depth map of each pair is left."""
