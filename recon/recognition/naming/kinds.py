"""Kinds of objects as rules over parts, shapes, places, sizes and colours."""

import itertools
from functools import cached_property
from typing import Annotated, Literal

from pydantic import AfterValidator, Field
from pydantic.dataclasses import dataclass

from recon.recognition.naming.descriptors import Learned
from recon.settings.stage import STRICT, NonNegative, Share

Shape = Literal["cylinder", "sphere", "ellipsoid", "cone", "box", "plane"]
Place = Literal["on", "beside", "under"]
AXIAL = frozenset({"cylinder", "sphere", "ellipsoid", "cone"})
"""Shapes that can stand on each other on one upright axis."""
FITTED = {"cone": "truncated cone"}
"""A cone is fitted with a free top: no map shows its tip."""


def _ordered(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] > limits[1]:
        raise ValueError(f"the range {list(limits)} falls, but the smaller number comes first")
    return limits


Range = Annotated[tuple[NonNegative, NonNegative], AfterValidator(_ordered)]
Counts = Annotated[tuple[int, int], AfterValidator(_ordered)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Sizes:
    """Bounds of a thing in metres; None where any will do."""

    height: Range | None = None
    """From its lowest to its highest point."""
    width: Range | None = None
    """The longer side of its footprint."""
    depth: Range | None = None
    """The shorter side of its footprint."""
    radius: Range | None = None
    """Of the widest circle round its axis."""

    @property
    def given(self) -> dict[str, tuple[float, float]]:
        """The bounds that are set, by name."""
        names = ("height", "width", "depth", "radius")
        return {name: limits for name in names if (limits := getattr(self, name)) is not None}


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PartRule:
    """One part of a kind of object."""

    role: Annotated[str, Field(min_length=1)]
    shapes: Annotated[tuple[Shape, ...], Field(min_length=1)]
    """Any of these."""
    place: Place = "on"
    """Relative to the part before it: on it, beside it, under it."""
    count: Counts = (1, 1)
    """Fewest and most of its like that are seen."""
    slenderness: Range | None = None
    """Bounds of its height over its radius; of a cone, over what its radius falls by; of a plane,
    over its extent along the floor."""
    tilt_deg: Range | None = None
    """Of a plane: bounds of the angle of its normal to the vertical; 0 lies, 90 stands."""
    share: Range | None = None
    """Bounds of its cells as a share of the object's."""
    size: Sizes = Sizes()
    hue_deg: tuple[float, float] | None = None
    """Bounds of its hue, round the circle: from 350 to 20 is red."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Kind:
    """One name, and what a thing must be to get it."""

    name: Annotated[str, Field(min_length=1)]
    parts: Annotated[tuple[PartRule, ...], Field(max_length=6)] = ()
    """From the ground up; empty for a kind that was learned."""
    ratio: Range | None = None
    """Bounds of the lowest part's largest radius over that of the part on it."""
    size: Sizes = Sizes()
    min_seen: Share = 0.0
    """Share of its surface that must be seen."""
    learned: Learned | None = None
    """Likeness of its examples, instead of parts."""

    def __post_init__(self) -> None:
        if bool(self.parts) == (self.learned is not None):
            raise ValueError("parts or learned is needed, and one of them only")

    @property
    def is_upright(self) -> bool:
        """True where its parts stand on each other on one axis."""
        return bool(self.parts) and all(
            AXIAL.issuperset(part.shapes) and part.place == "on" and part.count == (1, 1)
            for part in self.parts
        )

    @cached_property
    def composites(self) -> list[tuple[str, ...]]:
        """Every combination of fitted shapes that the parts allow; a cone may be truncated."""
        fitted = ({FITTED.get(shape, shape): None for shape in part.shapes} for part in self.parts)
        return list(itertools.product(*fitted))

    @property
    def needs_scale(self) -> bool:
        """True where it asks for sizes in metres."""
        return bool(self.size.given) or any(part.size.given for part in self.parts)
