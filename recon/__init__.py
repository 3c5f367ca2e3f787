"""recon reconstructs objects from stereo sequences.

The few names most people want are here, and are loaded when they are first used:
`match_pair` and `process_pair` (two images -> matches, a pair -> the map), `open_sequence` and
`World` (where pairs come from), `VoxelMap`, `recognise`, `Settings`.
"""

import importlib
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "Settings": "recon.settings",
    "VoxelMap": "recon.voxelmap",
    "World": "recon.world.world",
    "match_pair": "recon.mapping.pair",
    "open_sequence": "recon.sequences",
    "process_pair": "recon.mapping.pair",
    "recognise": "recon.recognition",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"recon has no {name}, but {', '.join(_HOMES)}")
    return getattr(importlib.import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
