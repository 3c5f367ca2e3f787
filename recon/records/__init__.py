"""Records shared by all packages: small, frozen, every field with its shape, unit and frame."""

from recon.records.clouds import Crs, GroundGrid, PointCloud, Segments, Voxels, cell_centres
from recon.records.estimates import PoseEstimate
from recon.records.matches import Features, Matches, check_alike
from recon.records.noise import ImageNoise
from recon.records.objects import (
    UNKNOWN,
    BoundingBox,
    ExplainingSolid,
    FoundObject,
    FoundPlane,
    Part,
    Recognition,
)
from recon.records.pairs import Image, PairSource, StereoPair, View, as_rgb, check_images
from recon.records.reconstruction import Reconstruction
from recon.records.solids import (
    Box,
    Cone,
    Cylinder,
    Ellipsoid,
    FitFailure,
    Plane,
    Solid,
    Sphere,
    TruncatedCone,
)
from recon.records.surfaces import DisparityMap, Mesh, MeshPart
from recon.records.trajectory import Trajectory

__all__ = [
    "UNKNOWN",
    "BoundingBox",
    "Box",
    "Cone",
    "Crs",
    "Cylinder",
    "DisparityMap",
    "Ellipsoid",
    "ExplainingSolid",
    "Features",
    "FitFailure",
    "FoundObject",
    "FoundPlane",
    "GroundGrid",
    "Image",
    "ImageNoise",
    "Matches",
    "Mesh",
    "MeshPart",
    "PairSource",
    "Part",
    "Plane",
    "PointCloud",
    "PoseEstimate",
    "Recognition",
    "Reconstruction",
    "Segments",
    "Solid",
    "Sphere",
    "StereoPair",
    "Trajectory",
    "TruncatedCone",
    "View",
    "Voxels",
    "as_rgb",
    "cell_centres",
    "check_alike",
    "check_images",
]
