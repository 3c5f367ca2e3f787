"""Settings of surfaces: the fusion of depths, and the files saved of it."""

from recon.settings.stage import Positive, table


@table
class SurfaceSettings:
    """Fusion of the depths of all pairs into one surface, where `dense.enabled` is set."""

    voxel: Positive | None = None
    """Side of a voxel, world units; none = two pixels at the depths of the first pair."""
    mesh: bool = False
    """Save a mesh besides the dense cloud."""
    watertight: bool = False
    """Save a mesh that is closed, extrapolated where nothing was seen."""
    depth_maps: bool = False
    """Save the depth map of each pair."""

    @property
    def wants_mesh(self) -> bool:
        """True if a mesh is saved, closed or not."""
        return self.mesh or self.watertight
