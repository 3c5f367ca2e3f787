"""The pairs of a run again: read from the recording, or rendered by the simulator."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.app.exhibit import Exhibit
from recon.errors import InputError
from recon.manifest import digest, input_paths, read_manifest
from recon.records import StereoPair, View
from recon.runs.reading import read_settings
from recon.settings import Settings
from recon.world.library import find_scene

Array = NDArray[np.float64]

AHEAD = 20.0
"""Distance of the target of a rendered view, world units, as a run keeps only poses."""
SPARSE, FEATURES, DENSE = "matched points", "features", "every pixel"
SHOWN = (SPARSE, FEATURES, DENSE)
"""Options of what to show of a pair besides its left image."""
KEPT = {SPARSE: "disparity", DENSE: "dense"}
"""The figure of a run without a map that has the data."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeenPair:
    """A pair of a run, and values at points of its left image."""

    left: NDArray[np.uint8]
    points_px: Array
    """(M, 2)"""
    values: Array
    """(M,) disparities in pixels, or orientations in degrees."""
    label: str
    """Name of the values, with their unit."""
    is_dense: bool = False

    @property
    def said(self) -> str:
        """The shown amount, in words."""
        if not self.is_dense:
            noun = "matched points" if self.label.startswith("disparity") else "features"
            return f"{len(self.values):,} {noun}"
        height, width = self.left.shape[:2]
        return f"disparity of {len(self.values) / (height * width):.0%} of the pixels"


class Pairs:
    """The pairs of one run, by number."""

    def __init__(self, exhibit: Exhibit) -> None:
        self.exhibit = exhibit
        self.take = lru_cache(maxsize=8)(self._take)
        self._pair = lru_cache(maxsize=2)(self._source)

    def _take(self, number: int, shown: str = SPARSE) -> SeenPair:
        """One pair, and one of SHOWN in it.

        Raises
        ------
        InputError
            If the input of the run no longer exists.
        """
        if self.exhibit.trajectory is None:
            return self._kept(shown)
        settings = read_settings(self.exhibit.path)
        return _seen(self._pair(number), shown, settings)

    def _kept(self, shown: str) -> SeenPair:
        """The pair that a run without a map stored for its figure."""
        from recon.runs.figures import read_arrays

        path = self.exhibit.path / "figures" / f"{KEPT.get(shown, shown)}.npz"
        if not path.exists():
            raise InputError(f"{self.exhibit.path} keeps no pair with its {shown}")
        arrays = read_arrays(path)
        if shown == DENSE:
            return _dense(arrays["left"], np.asarray(arrays["disparity_px"]))
        return _sparse(arrays["left"], arrays["points_px"], arrays["disparity_px"])

    def _source(self, number: int) -> StereoPair:
        manifest = read_manifest(self.exhibit.path)
        settings = read_settings(self.exhibit.path)
        if manifest["command"] == "explore":
            from recon.world.world import World

            world = World.from_file(self._input(manifest), settings)
            return world.take(self._view(number, settings))
        return _nth(self._input(manifest), number, settings)

    def _input(self, manifest: Mapping[str, Any]) -> Path:
        paths = input_paths(manifest)
        if not paths:
            raise InputError(f"{self.exhibit.path} does not state where its pairs are")
        return paths[0] if paths[0].exists() else _shipped(paths[0], manifest)

    def _view(self, number: int, settings: Settings) -> View:
        assert self.exhibit.trajectory is not None
        T = self.exhibit.trajectory.T_world_left[number]
        middle = T[:3, 3] + 0.5 * settings.eyes.baseline * T[:3, 0]
        return View(position=middle, target=middle + AHEAD * T[:3, 2])


def _shipped(path: Path, manifest: Mapping[str, Any]) -> Path:
    """The shipped scene of the same name and content as one that no longer exists."""
    fault = f"{path}, the input of the run, no longer exists"
    try:
        found = find_scene(Path(path.stem))
    except InputError as error:
        raise InputError(fault) from error
    if digest(found) != manifest["inputs"][0]["sha256"]:
        raise InputError(fault)
    return found


def _nth(path: Path, number: int, settings: Settings) -> StereoPair:
    from recon.sequences.open import open_sequence

    for pair in open_sequence(path, settings.sequence)[number : number + 1]:
        return pair
    raise InputError(f"{path} no longer has a pair {number}")


def _seen(pair: StereoPair, shown: str, settings: Settings) -> SeenPair:
    from recon.mapping.sparse import match_sparse
    from recon.stereo.dense.dense import match_every_pixel
    from recon.stereo.features import detect

    images = pair.left, pair.right
    if shown == DENSE:
        dense = match_every_pixel(*images, settings, pair.disparity_range)
        return _dense(pair.left, dense.disparity_px)
    if shown == FEATURES:
        found = detect(pair.left, settings.features)
        return SeenPair(
            left=pair.left, points_px=np.asarray(found.points_px, np.float64),
            values=np.degrees(found.orientation_rad).astype(np.float64), label="orientation [deg]",
        )  # fmt: skip
    matches = match_sparse(*images, settings, pair.disparity_range, pair.rig.residual_px).matches
    return _sparse(pair.left, matches.points_px, matches.disparity_px)


def _sparse(left: NDArray[np.uint8], points_px: Array, disparity_px: Array) -> SeenPair:
    values = np.asarray(disparity_px, np.float64)
    return SeenPair(left=left, points_px=points_px, values=values, label="disparity [px]")


def _dense(left: NDArray[np.uint8], disparity_px: NDArray[np.floating]) -> SeenPair:
    v, u = np.nonzero(np.isfinite(disparity_px))
    return SeenPair(
        left=left, points_px=np.stack([u, v], axis=1).astype(np.float64),
        values=disparity_px[v, u].astype(np.float64), label="disparity [px]", is_dense=True,
    )  # fmt: skip
