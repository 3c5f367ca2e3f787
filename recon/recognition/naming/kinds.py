"""Kinds of objects as rules for parts, shapes, positions, sizes and colours."""

import itertools
from functools import cached_property
from typing import Annotated, Literal

from pydantic import AfterValidator, Field
from pydantic.dataclasses import dataclass

from recon.recognition.naming.descriptors import Learned
from recon.records import UNKNOWN
from recon.settings.stage import STRICT, NonNegative, Share

Shape = Literal["cylinder", "sphere", "ellipsoid", "cone", "box", "plane"]
Place = Literal["on", "beside", "under"]
AXIAL = frozenset({"cylinder", "sphere", "ellipsoid", "cone"})
"""Shapes that can be stacked on one vertical axis."""
FITTED = {"cone": "truncated cone"}
"""A cone is fitted with a free top radius, since maps do not show its tip."""


def _ordered(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] > limits[1]:
        raise ValueError(
            f"the range {list(limits)} is reversed, but the smaller number comes first"
        )
    return limits


Range = Annotated[tuple[NonNegative, NonNegative], AfterValidator(_ordered)]
Counts = Annotated[tuple[int, int], AfterValidator(_ordered)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Sizes:
    """Size limits of an object in metres; None = no limit."""

    height: Range | None = None
    """From its lowest to its highest point."""
    width: Range | None = None
    """The longer side of its footprint."""
    depth: Range | None = None
    """The shorter side of its footprint."""
    radius: Range | None = None
    """Radius of the widest circle around its axis."""

    @property
    def given(self) -> dict[str, tuple[float, float]]:
        """The limits that are set, by name."""
        names = ("height", "width", "depth", "radius")
        return {name: limits for name in names if (limits := getattr(self, name)) is not None}


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PartRule:
    """One part of a kind of object."""

    role: Annotated[str, Field(min_length=1)]
    shapes: Annotated[tuple[Shape, ...], Field(min_length=1)]
    """Allowed shapes."""
    place: Place = "on"
    """Relative to the previous part: on, beside or under it, and then below a level plane too."""
    count: Counts = (1, 1)
    """Minimum and maximum number of such parts."""
    slenderness: Range | None = None
    """Limits of its height over its radius; for a cone, over the decrease of its radius; for a
    plane, over its extent along the floor."""
    tilt_deg: Range | None = None
    """For a plane: limits of the angle between its normal and the vertical; 0 = horizontal, 90 =
    vertical."""
    square: bool = False
    """For several upright planes: they are parallel or at right angles, as walls are, with a
    corner."""
    share: Range | None = None
    """Limits of its cells as a share of the object's cells."""
    level: Range | None = None
    """Beside and under others: limits of the height of its middle over that of the object's top."""
    size: Sizes = Sizes()
    hue_deg: tuple[float, float] | None = None
    """Bounds of its hue, round the circle: from 350 to 20 is red. Of another hue a part speaks
    against the kind, and does not rule it out."""


NAME_NEED = f"one line other than {UNKNOWN!r} is needed"


def may_be_named(name: str) -> bool:
    """True of a name in one line that is not the label of what has none."""
    return name.isprintable() and name != UNKNOWN


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Kind:
    """A name and the requirements for it."""

    name: Annotated[str, Field(min_length=1)]
    parts: Annotated[tuple[PartRule, ...], Field(max_length=6)] = ()
    """From the ground up; empty for a learned kind."""
    ratio: Range | None = None
    """Limits of the lowest part's largest radius over that of the part on it."""
    slenderness: Range | None = None
    """Limits of its height over its largest radius, whatever its scale."""
    elongation: Range | None = None
    """Limits of the longer side of its footprint over the shorter one."""
    size: Sizes = Sizes()
    min_seen: Share = 0.0
    """Minimum visible share of its surface."""
    learned: Learned | None = None
    """Description learned from examples, instead of parts."""

    def __post_init__(self) -> None:
        if bool(self.parts) == (self.learned is not None):
            raise ValueError("exactly one of parts and learned is needed")
        if not may_be_named(self.name):
            raise ValueError(f"its name is {self.name!r}, but {NAME_NEED}")

    @property
    def is_upright(self) -> bool:
        """True if its parts are stacked on one vertical axis."""
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
        """True if it has size limits in metres, and no proportions that distinguish it without."""
        has_sizes = bool(self.size.given) or any(part.size.given for part in self.parts)
        return has_sizes and not (self.ratio or self.slenderness or self.elongation)
