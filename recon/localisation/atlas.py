"""An atlas: the places of a run with their poses in one file."""

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.errors import InputError
from recon.sequences.odometry.places import Place
from recon.sequences.odometry.tracking import Sightings
from recon.voxelmap import archive

Array = NDArray[np.float64]

VERSION = 2
RIG_FIELDS = tuple(StereoRig.__dataclass_fields__)


@dataclass(slots=True, kw_only=True, eq=False)
class Atlas:
    """The places seen, in order."""

    places: list[Place]
    numbers: list[int]
    """Numbers of the pairs in which the places were seen."""
    T_world_left: Array
    """(P, 4, 4)"""

    def __len__(self) -> int:
        return len(self.places)

    @property
    def summaries(self) -> Array:
        """Summaries (P, W) of the places."""
        return np.array([place.summary for place in self.places])

    @property
    def depths(self) -> Array:
        """Median depths (P,) of the places, world units."""
        return np.array([place.depth for place in self.places])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the atlas, whole or not at all; identical places give identical bytes."""
        seen = [place.sightings for place in self.places]
        archive.save(
            path,
            {
                "version": np.array(VERSION),
                "number": np.array(self.numbers, np.int64),
                "T_world_left": self.T_world_left.reshape(-1, 4, 4),
                "rig": np.array([_row(place.rig) for place in self.places]).reshape(
                    -1, len(RIG_FIELDS)
                ),
                "num_points": np.array([len(place) for place in self.places], np.int64),
                "points_px": _joined([one.points_px for one in seen], (0, 2)),
                "disparity_px": _joined([one.disparity_px for one in seen], (0,)),
                "descriptors": np.concatenate(
                    [np.zeros((0, 128), np.uint8), *(place.descriptors for place in self.places)]
                ),
            },
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Atlas":
        """Read what `save` wrote.

        Raises
        ------
        InputError
            If the file is not an atlas or is damaged.
        """
        columns = archive.read_columns(path)
        try:
            return _atlas(columns)
        except (KeyError, ValueError, TypeError, IndexError) as error:
            raise InputError(f"{path}: not the places of a run ({error})") from error


def _row(rig: StereoRig) -> list[float]:
    return [float(getattr(rig, name)) for name in RIG_FIELDS]


def _joined(parts: list[Array], none: tuple[int, ...]) -> NDArray[np.float32]:
    joined: NDArray[np.float32] = np.concatenate([np.zeros(none), *parts]).astype(np.float32)
    return joined


def _rig(row: Array) -> StereoRig:
    values = dict(zip(RIG_FIELDS, row.tolist(), strict=True))
    whole = {name: int(values.pop(name)) for name in ("width", "height")}
    return StereoRig(**whole, **values)


def _atlas(columns: archive.Columns) -> Atlas:
    if int(columns["version"]) != VERSION:
        raise InputError(f"version {columns['version']}, but {VERSION} is needed")
    numbers, poses = columns["number"], columns["T_world_left"].astype(np.float64)
    ends = np.cumsum(columns["num_points"])[:-1]
    parts = [
        np.split(columns[name].astype(kind), ends)
        for name, kind in (
            ("points_px", np.float64), ("disparity_px", np.float64), ("descriptors", np.uint8),
        )
    ]  # fmt: skip
    num_points = int(columns["num_points"].sum())
    shapes = {"T_world_left": (len(numbers), 4, 4), "rig": (len(numbers), len(RIG_FIELDS)),
              "points_px": (num_points, 2), "disparity_px": (num_points,),
              "descriptors": (num_points, 128), "num_points": (len(numbers),)}  # fmt: skip
    for name, shape in shapes.items():
        if columns[name].shape != shape or not np.isfinite(columns[name]).all():
            raise ValueError(f"{name} has shape {columns[name].shape}, but {shape} is needed")
    if not len(numbers):
        return Atlas(places=[], numbers=[], T_world_left=poses)
    places = [
        Place(
            rig=_rig(row),
            sightings=Sightings(
                points_px=points, disparity_px=disparity, row_offset_px=np.zeros(len(points))
            ),
            descriptors=descriptors,
        )
        for row, points, disparity, descriptors in zip(columns["rig"], *parts, strict=True)
    ]
    return Atlas(places=places, numbers=[int(n) for n in numbers], T_world_left=poses)
