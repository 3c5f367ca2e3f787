"""The pairs of the thesis: from the recorded data beside the project, or a rendered stand-in."""

import os
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.records import View
from recon.sequences.images import read_image
from recon.sequences.truth import read_truth
from recon.settings import Settings, updated
from recon.world.world import World
from reproduction.blocks import blocks_scene
from reproduction.entry import Absent

DATA = Path(os.environ.get("RECON_DATA", Path(__file__).parents[3] / "shared" / "data"))
MARGIN_PX = 4
BLOCKS = {"Blocks 1": (-6.0, 9.0, 13.0), "Blocks 2": (0.0, 11.0, 14.0)}
"""Positions of the camera, both of the same blocks."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TruePair:
    """Two rectified images with the true disparity of the left one."""

    name: str
    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    truth_px: NDArray[np.float64]
    """(H, W), NaN = unknown."""
    quantisation_px: float
    """Step of the truth."""

    @property
    def search(self) -> dict[str, int]:
        """Give a search range slightly wider than the range of the truth."""
        low = min(0, int(np.floor(np.nanmin(self.truth_px))) - MARGIN_PX)
        return {
            "min_disparity": low,
            "max_disparity": int(np.ceil(np.nanmax(self.truth_px))) + MARGIN_PX,
        }


@cache
def recorded(name: str) -> TruePair:
    """Load a Middlebury pair of 2001."""
    folder = DATA / "middlebury2001" / name.lower()
    if not folder.is_dir():
        raise Absent(f"the pair {name} is not there: set RECON_DATA to the recorded data")
    left, right = (next(folder.glob(f"{side}.*")) for side in ("left", "right"))
    truth = read_truth(folder)
    return TruePair(
        name=name,
        left=read_image(left),
        right=read_image(right),
        truth_px=truth.disparity_px,
        quantisation_px=truth.quantisation_px,
    )


@cache
def blocks(name: str) -> TruePair:
    """Render the stand-in for a blocks pair of CMU, with its truth."""
    eyes = {"width": 384, "height": 288, "baseline": 1.0, "fov_deg": 45.0}
    settings = updated(Settings(), {"eyes": eyes, "render": {"noise": 1.0}})
    world = World(blocks_scene(), eyes=settings.eyes, render=settings.render, world=settings.world)
    view = View(position=np.array(BLOCKS[name]), target=np.array([0.0, 0.5, -2.5]))
    pair = world.take(view)
    depth = world.truth(view).depth
    return TruePair(
        name=f"{name} (stand-in)",
        left=pair.left,
        right=pair.right,
        truth_px=np.where(np.isfinite(depth), pair.rig.disparity(depth), np.nan),
        quantisation_px=0.0,
    )
