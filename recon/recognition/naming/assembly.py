"""Assemblies: kinds of planes and other pieces that lie on, beside and under each other."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.naming.kinds import Kind
from recon.records import Solid, Voxels

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Assembly:
    """Pieces that make up one kind."""

    kind: Kind
    criterion: float
    probability: float
    seen: float
    solids: tuple[Solid, ...]
    roles: tuple[str, ...]


def assemblies(cells: Voxels, ground: float, kinds: list[Kind]) -> list[Assembly]:
    """Every kind whose parts are all found among the pieces of an object."""
    return []
