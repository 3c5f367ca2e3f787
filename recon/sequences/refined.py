"""Estimates for a whole recording, made once, with which any part can be read by itself."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, as_numbers, check_finite, check_shape
from recon.files import PathLike, atomic_path
from recon.files.documents import read_json
from recon.geometry import check_rigid
from recon.records import PairSource, StereoPair
from recon.sequences.calibration.refinement import RefinedPairs
from recon.sequences.calibration.row_error import NUM_TERMS, Field, Residual
from recon.sequences.estimated_poses import EstimatedPoses
from recon.sequences.frames import DerivedSource

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Refined:
    """Rectification and poses that follow from all pairs of a recording."""

    residual: Residual
    """Residual of the rectification."""
    poses: Mapping[str, Array] = field(default_factory=dict)
    """`T_world_left` (4, 4) by the name of the pair if poses are estimated; else empty."""

    def write(self, path: Path) -> None:
        """Write the record as JSON."""
        document = {
            "row_residual_px": self.residual.row.coefficients.tolist(),
            "disparity_residual_px": self.residual.disparity.coefficients.tolist(),
            "poses": {name: pose.tolist() for name, pose in self.poses.items()},
        }
        with atomic_path(path) as part:
            part.write_text(json.dumps(document) + "\n", encoding="utf-8")

    def pairs(self, recording: DerivedSource) -> DerivedSource:
        """The pairs of the recording, refined; nothing is estimated again."""
        straight = RefinedPairs(recording, lambda _: self.residual)
        return RecordedPoses(straight, self.poses) if self.poses else straight


class RecordedPoses(DerivedSource):
    """Pairs with their poses from a record."""

    def __init__(self, source: PairSource, poses: Mapping[str, Array]) -> None:
        super().__init__(source)
        self._poses = poses

    def __iter__(self) -> Iterator[StereoPair]:
        for pair in self.source:
            if pair.name not in self._poses:
                raise InputError(f"{pair.name} has no pose in the record of the recording")
            yield replace(pair, T_world_left=self._poses[pair.name])


def refine(source: DerivedSource) -> Refined:
    """The record of an open recording; estimated poses take a pass over all of it."""
    estimated = next((one for one in _layers(source) if isinstance(one, EstimatedPoses)), None)
    if estimated is not None:
        poses = {pair.name: _pose(pair) for pair in estimated}
        return Refined(residual=estimated.residual, poses=poses)
    straight = next((one for one in _layers(source) if isinstance(one, RefinedPairs)), None)
    return Refined(residual=Residual() if straight is None else straight.residual)


def _pose(pair: StereoPair) -> Array:
    assert pair.T_world_left is not None
    return pair.T_world_left


def _layers(source: PairSource) -> Iterator[PairSource]:
    """A source and the sources it derives from."""
    yield source
    if isinstance(source, DerivedSource):
        yield from _layers(source.source)


def read_refined(path: PathLike) -> Refined:
    """The record written by `Refined.write`.

    Raises
    ------
    InputError
        If it is not one.
    """
    document = read_json(path)
    try:
        fields = [_field(document, f"{name}_residual_px") for name in ("row", "disparity")]
        poses = {name: _checked(name, pose) for name, pose in document["poses"].items()}
    except (KeyError, TypeError, AttributeError, InputError) as error:
        raise InputError(f"{path}: not the record of a recording ({error})") from error
    return Refined(residual=Residual(row=fields[0], disparity=fields[1]), poses=poses)


def _field(document: Any, name: str) -> Field:
    coefficients = as_numbers(name, document[name])
    check_shape(name, coefficients, (NUM_TERMS,))
    check_finite(name, coefficients)
    return Field(coefficients=coefficients)


def _checked(name: str, pose: Any) -> Array:
    T_world_left = as_numbers(name, pose)
    check_rigid(name, T_world_left)
    return T_world_left
