"""Conversion of maps and clouds to and from files and objects of other programs."""

from recon.exports.formats import FORMATS, format_of, read, read_mesh, write
from recon.exports.open3d import as_point_cloud, as_voxel_grid, of_point_cloud, of_voxel_grid
from recon.exports.vti import as_image, of_image

__all__ = [
    "FORMATS",
    "as_image",
    "as_point_cloud",
    "as_voxel_grid",
    "format_of",
    "of_image",
    "of_point_cloud",
    "of_voxel_grid",
    "read",
    "read_mesh",
    "write",
]
