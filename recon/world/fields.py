"""The values of a geometry file: their order, their comments and their valid ranges."""

from dataclasses import dataclass

from recon.world.visuals import (
    CylinderVisual,
    EllipsoidVisual,
    MeshVisual,
    PolygonVisual,
    SphereVisual,
    Visual,
)

Value = float | int | str | tuple[float, ...]

LIMIT = 1e9
"""Largest number: coordinates and their squares have to fit into single precision."""

LEAST = 1e-9
"""Smallest size."""


@dataclass(frozen=True, slots=True)
class Kind:
    """The type and range of the values of a line."""

    need: str
    """For messages: what is needed."""
    count: int = 1
    least: float = -LIMIT
    most: float = LIMIT
    is_whole: bool = False

    def parse(self, text: str) -> Value:
        """The value of a line; a single number is not a tuple.

        Raises
        ------
        ValueError
            If the line holds anything else.
        """
        numbers = tuple(int(word) if self.is_whole else float(word) for word in text.split())
        if len(numbers) != self.count:
            raise ValueError
        if not all(self.least <= n <= self.most for n in numbers):
            raise ValueError
        return numbers if self.count > 1 else numbers[0]


@dataclass(frozen=True, slots=True)
class Name(Kind):
    """A line that is a name."""

    def parse(self, text: str) -> Value:
        """The line as it is."""
        return text


@dataclass(frozen=True, slots=True)
class Field:
    """One value of a record: its attribute, the comment above it, and its kind."""

    attribute: str
    comment: str
    kind: Kind


def whole(least: int, most: int | None = None) -> Kind:
    """Whole numbers from `least` to `most`, both included."""
    need = f"a whole number from {least}" + ("" if most is None else f" to {most}")
    return Kind(need, least=least, most=LIMIT if most is None else most, is_whole=True)


POSITIVE = Kind("a number above 0, up to 1e9", least=LEAST)
NOT_NEGATIVE = Kind("a number from 0 to 1e9", least=0.0)
VECTOR = Kind("a line of three numbers within 1e9", count=3)
POSITIVE_VECTOR = Kind("a line of three numbers above 0, up to 1e9", count=3, least=LEAST)
COLOUR = Kind("a line of four numbers within 1e9", count=4)
VERTEX = Kind("a line of nine numbers within 1e9 (x y z r g b a tu tv)", count=9)

SHADER_FIELDS = (
    Field("ambient", "Ambient color", COLOUR),
    Field("diffuse", "Diffuse color", COLOUR),
    Field("specular", "Specular color", COLOUR),
    Field("emissive", "Emissive color", COLOUR),
    Field("shininess", "Shininess [0,128]", Kind("a number from 0 to 128", least=0, most=128)),
)

# The fields of each visual before its shader and texture index; the corners of a polygon follow
# these.
VISUAL_FIELDS: dict[type[Visual], tuple[Field, ...]] = {
    SphereVisual: (Field("centre", "Center", VECTOR), Field("radius", "Radius", POSITIVE)),
    EllipsoidVisual: (
        Field("centre", "Center", VECTOR),
        Field("radii", "Radii [x,y,z]", POSITIVE_VECTOR),
    ),
    CylinderVisual: (
        Field("radius_base", "RadiusBase", NOT_NEGATIVE),
        Field("radius_top", "RadiusTop", NOT_NEGATIVE),
        Field("height", "Height", POSITIVE),
        Field("slices", "Slices", whole(3)),
        Field("stacks", "Stacks", whole(1)),
        Field("translation", "Translation [x,y,z]", VECTOR),
        Field("rotation", "Rotation [x,y,z]", VECTOR),
    ),
    PolygonVisual: (Field("cull_back", "Enable back face culling", whole(0, 1)),),
    MeshVisual: (Field("file", "File", Name("a PLY or OBJ file")),),
}

STRUCTURE = frozenset(
    (
        *("shader count", "texture count", "visual count", "visual type"),
        *("shader index", "texture index", "vertex count"),
    )
)
"""Comments of values that do not belong to one kind of record, lower case."""
