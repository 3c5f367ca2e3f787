"""Pairs that a run has taken, kept until it is finished, so that a cut run can go on."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from recon.camera import StereoRig
from recon.files import atomic_path
from recon.records import StereoPair

RIG_FIELDS = tuple(StereoRig.__dataclass_fields__)


@dataclass(slots=True, kw_only=True)
class SavedPairs:
    """A folder of numbered pairs; one that is there is replayed instead of taken again."""

    folder: Path

    def path(self, number: int) -> Path:
        """Where pair `number` is kept."""
        return self.folder / f"{number:06d}.npz"

    def save(self, number: int, pair: StereoPair) -> None:
        """Keep one pair, whole."""
        pose = np.eye(4) if pair.T_world_left is None else pair.T_world_left
        rig = np.array([getattr(pair.rig, name) for name in RIG_FIELDS], dtype=np.float64)
        with atomic_path(self.path(number)) as part, part.open("wb") as stream:
            np.savez(
                stream, left=pair.left, right=pair.right, T_world_left=pose,
                rig=rig, stamp_s=pair.stamp_s, name=pair.name,
            )  # fmt: skip

    def load(self, number: int) -> StereoPair | None:
        """Pair `number`, or None where it was not taken yet."""
        if not self.path(number).exists():
            return None
        with np.load(self.path(number), allow_pickle=False) as saved:
            values = dict(zip(RIG_FIELDS, saved["rig"].tolist(), strict=True))
            whole = {name: int(values.pop(name)) for name in ("width", "height")}
            return StereoPair(
                left=saved["left"], right=saved["right"], T_world_left=saved["T_world_left"],
                rig=StereoRig(**whole, **values),
                stamp_s=float(saved["stamp_s"]), name=str(saved["name"]),
            )  # fmt: skip
