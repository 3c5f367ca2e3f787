"""The content of a geometry file: shaders and visuals of a world (thesis Appendix B)."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

Vector = tuple[float, float, float]
Colour = tuple[float, float, float, float]

NONE = -1
"""The index that means no shader or no texture."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shader:
    """A material of OpenGL's fixed pipeline; colours are red, green, blue, alpha from 0 to 1."""

    ambient: Colour
    diffuse: Colour
    specular: Colour
    emissive: Colour
    shininess: float
    """0 to 128."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SphereVisual:
    """A sphere."""

    kind: ClassVar[str] = "SPHERE"
    centre: Vector
    radius: float
    shader: int = NONE
    texture: int = NONE


@dataclass(frozen=True, slots=True, kw_only=True)
class EllipsoidVisual:
    """An ellipsoid with its axes along those of the world."""

    kind: ClassVar[str] = "ELLIPSOID"
    centre: Vector
    radii: Vector
    shader: int = NONE
    texture: int = NONE


@dataclass(frozen=True, slots=True, kw_only=True)
class CylinderVisual:
    """An open cylinder or (truncated) cone, from its base end along its own +z axis."""

    kind: ClassVar[str] = "CYLINDER"
    radius_base: float
    radius_top: float
    height: float
    slices: int = 36
    stacks: int = 20
    translation: Vector
    """The middle of the base end: with a rotation of 1 0 0 that is the UPPER end."""
    rotation: Vector = (1.0, 0.0, 0.0)
    """Quarter turns about x, then y, then z: 1 0 0 turns +z to -y."""
    shader: int = NONE
    texture: int = NONE


@dataclass(frozen=True, slots=True, kw_only=True)
class Vertex:
    """A corner of a polygon."""

    position: Vector
    colour: Colour
    uv: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class PolygonVisual:
    """A convex polygon, its front where its corners run counter-clockwise."""

    kind: ClassVar[str] = "POLYGON"
    cull_back: bool
    """True if invisible from behind."""
    shader: int = NONE
    texture: int = NONE
    vertices: tuple[Vertex, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshVisual:
    """Triangles of a PLY or OBJ file, in world coordinates."""

    kind: ClassVar[str] = "MESH"
    file: str
    """Relative to the folder of the scene."""
    shader: int = NONE
    texture: int = NONE


Visual = SphereVisual | EllipsoidVisual | CylinderVisual | PolygonVisual | MeshVisual


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """The content of a geometry file, in file order; indices start at 0."""

    shaders: tuple[Shader, ...] = ()
    textures: tuple[str, ...] = ()
    """Names as in the file, "textures/wood.tga"."""
    visuals: tuple[Visual, ...]
    folder: Path | None = None
    """Folder of its textures and meshes; None if the scene was not read from a file."""

    def texture_of(self, visual: Visual) -> str | None:
        """The name of a visual's texture."""
        return None if visual.texture == NONE else self.textures[visual.texture]
