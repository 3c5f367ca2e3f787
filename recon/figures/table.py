"""The table of figures; a new kind needs its file and a line here, or an entry point."""

from typing import TYPE_CHECKING

from recon.plugins import Registry

if TYPE_CHECKING:
    from recon.figures.kinds import Kind

_MAPPED, _KEPT = "recon.figures.mapped", "recon.figures.kept"
KINDS: "Registry[Kind]" = Registry(
    "recon.figures",
    "kind of figure",
    {
        "map3d": f"{_MAPPED}:MAP3D",
        "solids": f"{_MAPPED}:SOLIDS",
        "parts": f"{_MAPPED}:PARTS",
        "counts": f"{_MAPPED}:COUNTS",
        "sigma": f"{_MAPPED}:SIGMA",
        "slices": f"{_MAPPED}:SLICES",
        "occupancy": f"{_MAPPED}:OCCUPANCY",
        "labels": f"{_MAPPED}:LABELS",
        "trajectory": f"{_MAPPED}:TRAJECTORY",
        "mesh": f"{_MAPPED}:MESH",
        "overview": f"{_KEPT}:OVERVIEW",
        "disparity": f"{_KEPT}:DISPARITY",
        "dense": f"{_KEPT}:DENSE",
        "depth": "recon.figures.depth:DEPTH",
        "dense_errors": "recon.figures.dense:ERRORS",
        "dense_sigmas": "recon.figures.dense:SIGMAS",
        "errors": f"{_KEPT}:ERRORS",
        "scales": f"{_KEPT}:SCALES",
        "tuning": f"{_KEPT}:TUNING",
        "mixture": f"{_KEPT}:MIXTURE",
        "confusion": f"{_KEPT}:CONFUSION",
        "reliability": f"{_KEPT}:RELIABILITY",
    },
)
"""Every kind by name."""
