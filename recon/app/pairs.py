"""The pairs of a run once more: read again where it was recorded, taken again where simulated."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.app.exhibit import Exhibit
from recon.errors import InputError
from recon.figures import scales
from recon.figures.kept import kept_pair
from recon.mapping.pair import match_images
from recon.records import Matches, StereoPair, View
from recon.runfolder import read_manifest
from recon.runs.figures import read_arrays
from recon.runs.reading import read_settings
from recon.sequences.open import open_sequence
from recon.settings import Settings
from recon.world.world import World

AHEAD = 20.0
"""How far ahead a view that is taken again looks, world units: a run keeps poses, not targets."""
DIM = 0.45
DOT_PX = 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeenPair:
    """A pair of a run, and what was matched in it."""

    left: NDArray[np.uint8]
    arrays: Mapping[str, NDArray[Any]]
    """`points_px` and `disparity_px` in it."""


class Pairs:
    """The pairs of one run, by number."""

    def __init__(self, exhibit: Exhibit) -> None:
        self.exhibit = exhibit
        self.take = lru_cache(maxsize=8)(self._take)

    def _take(self, number: int) -> SeenPair:
        """One pair.

        Raises
        ------
        InputError
            Where what the run was made of is not there any more.
        """
        if self.exhibit.trajectory is None:
            return self._kept()
        settings = read_settings(self.exhibit.path)
        pair = self._source(number, settings)
        matches = match_images(pair.left, pair.right, settings, pair.disparity_range)
        return _seen(pair, matches)

    def _kept(self) -> SeenPair:
        """The pair that a run without a map kept for its figure."""
        path = self.exhibit.path / "figures" / "disparity.npz"
        if not path.exists():
            raise InputError(f"{self.exhibit.path} keeps no pair")
        arrays = read_arrays(path)
        return SeenPair(left=arrays["left"], arrays=arrays)

    def _source(self, number: int, settings: Settings) -> StereoPair:
        manifest = read_manifest(self.exhibit.path)
        if manifest["command"] == "explore":
            return self._world(settings).take(self._view(number, settings))
        return _nth(self._input(manifest), number, settings)

    def _input(self, manifest: Mapping[str, Any]) -> Path:
        paths = [Path(path) for path in manifest.get("input_paths", [])]
        if not paths:
            raise InputError(f"{self.exhibit.path} does not say where its pairs are")
        if not paths[0].exists():
            raise InputError(f"{paths[0]}, of which the run was made, is not there any more")
        return paths[0]

    def _world(self, settings: Settings) -> World:
        return World.from_file(self._input(read_manifest(self.exhibit.path)), settings)

    def _view(self, number: int, settings: Settings) -> View:
        assert self.exhibit.trajectory is not None
        T = self.exhibit.trajectory.T_world_left[number]
        middle = T[:3, 3] + 0.5 * settings.eyes.baseline * T[:3, 0]
        return View(position=middle, target=middle + AHEAD * T[:3, 2])


def _nth(path: Path, number: int, settings: Settings) -> StereoPair:
    for place, pair in enumerate(open_sequence(path, settings.sequence)):
        if place == number:
            return pair
    raise InputError(f"{path} has no pair {number}")


def _seen(pair: StereoPair, matches: Matches) -> SeenPair:
    return SeenPair(left=pair.left, arrays=kept_pair(pair.left, matches))


def with_disparity(seen: SeenPair) -> NDArray[np.uint8]:
    """The dimmed left image (H, W, 3) with every matched point in the colour of its disparity."""
    left = seen.left if seen.left.ndim == 3 else np.repeat(seen.left[..., None], 3, axis=2)
    grey = np.asarray(DIM * left.mean(axis=2), np.uint8)
    image: NDArray[np.uint8] = np.repeat(grey[..., None], 3, axis=2)
    values = np.asarray(seen.arrays["disparity_px"], np.float64)
    if not len(values):
        return image
    scale = scales.coloured(values, scales.disparity())
    colours = scales.rgb(scale, values)
    height, width = image.shape[:2]
    u, v = np.rint(seen.arrays["points_px"]).astype(int).T
    for down in range(-DOT_PX, DOT_PX + 1):
        for right in range(-DOT_PX, DOT_PX + 1):
            rows, columns = np.clip(v + down, 0, height - 1), np.clip(u + right, 0, width - 1)
            image[rows, columns] = colours
    return image
