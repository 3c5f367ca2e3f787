"""Pairs and results of a run, saved until it is finished, so that it can be resumed."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from recon.camera import StereoRig
from recon.errors import InputError
from recon.files import atomic_path
from recon.mapping.pair import PairResult
from recon.records import Matches, PointCloud, StereoPair
from recon.voxelmap.archive import Columns, read_columns

log = logging.getLogger(__name__)
Record = TypeVar("Record")

_PARTS = "matches", "cloud", "doubtful"
"""Parts of a result, saved field by field."""
RIG_FIELDS = tuple(StereoRig.__dataclass_fields__)


@dataclass(slots=True, kw_only=True)
class SavedPairs:
    """A folder of numbered pairs; existing ones are replayed instead of taken again."""

    folder: Path

    def path(self, number: int) -> Path:
        """File of pair `number`."""
        return self.folder / f"{number:06d}.npz"

    def save(self, number: int, pair: StereoPair) -> None:
        """Save one pair atomically."""
        pose = np.eye(4) if pair.T_world_left is None else pair.T_world_left
        rig = np.array([getattr(pair.rig, name) for name in RIG_FIELDS], dtype=np.float64)
        with atomic_path(self.path(number)) as part, part.open("wb") as stream:
            np.savez(
                stream, left=pair.left, right=pair.right, T_world_left=pose,
                rig=rig, stamp_s=pair.stamp_s, name=pair.name,
            )  # fmt: skip

    def load(self, number: int) -> StereoPair | None:
        """Pair `number`; None if it was not taken yet, or its file is damaged."""
        return _loaded(self.path(number), _as_pair)


@dataclass(slots=True, kw_only=True)
class SavedResults:
    """A folder of numbered results of pairs, which need not be computed again."""

    folder: Path

    def path(self, number: int) -> Path:
        """File of the result of pair `number`."""
        return self.folder / f"{number:06d}.npz"

    def keep(self, number: int, result: PairResult) -> PairResult:
        """Save one result atomically, and return it."""
        arrays = {
            f"{part}.{field.name}": array
            for part in _PARTS
            for field in fields(getattr(result, part))
            if isinstance(array := getattr(getattr(result, part), field.name), np.ndarray)
        }
        with atomic_path(self.path(number)) as path, path.open("wb") as stream:
            np.savez(stream, allow_pickle=False, image_noise=result.image_noise, **arrays)
        return result

    def load(self, number: int) -> PairResult | None:
        """The result of pair `number`; None if there is none, or its file is damaged."""
        return _loaded(self.path(number), _as_result)


def _loaded(path: Path, build: Callable[[Columns], Record]) -> Record | None:
    """The record of a file; None if missing or damaged."""
    try:
        return build(read_columns(path)) if path.exists() else None
    except (InputError, KeyError, TypeError, ValueError, IndexError, OverflowError) as error:
        log.warning("%s is damaged (%s); its pair is processed again", path, error)
        return None


def _as_pair(saved: Columns) -> StereoPair:
    values = dict(zip(RIG_FIELDS, saved["rig"].tolist(), strict=True))
    whole = {name: int(values.pop(name)) for name in ("width", "height")}
    return StereoPair(
        left=saved["left"], right=saved["right"], T_world_left=saved["T_world_left"],
        rig=StereoRig(**whole, **values),
        stamp_s=float(saved["stamp_s"]), name=str(saved["name"]),
    )  # fmt: skip


def _as_result(saved: Columns) -> PairResult:
    parts: dict[str, dict[str, Any]] = {part: {} for part in _PARTS}
    left, right = saved["image_noise"].tolist()
    for name, values in saved.items():
        part, _, field = name.partition(".")
        if part in parts:
            parts[part][field] = values
    return PairResult(
        matches=Matches(**parts["matches"]),
        cloud=PointCloud(**parts["cloud"]),
        doubtful=PointCloud(**parts["doubtful"]),
        image_noise=(left, right),
    )
