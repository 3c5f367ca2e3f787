"""Settings of recorded sequences."""

from typing import Literal

from pydantic.dataclasses import dataclass

from recon.settings.stage import STRICT, Count


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SequenceSettings:
    """Which pairs of a recording are read, and where their poses come from."""

    format: Literal["auto", "folder", "kitti", "euroc", "middlebury", "ring", "video", "bag"] = (
        "auto"
    )
    poses: Literal["given", "estimated", "none"] = "given"
    every: Count = 1
