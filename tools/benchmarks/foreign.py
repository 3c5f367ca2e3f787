"""Worlds of objects unknown to all catalogues: balls, rocks, posts, boxes, walls, fences."""

from dataclasses import dataclass, field

import numpy as np

from recon.world.furniture import TEXTURES
from recon.world.generator import Kind, random_scene
from recon.world.visuals import (
    CylinderVisual,
    EllipsoidVisual,
    PolygonVisual,
    Scene,
    SphereVisual,
    Vector,
    Vertex,
    Visual,
)

TILE = 6.0
"""World units that a texture covers on a plane."""
WHITE = (1.0, 1.0, 1.0, 1.0)
PALE_RADIUS, PALE_SPACING = 0.4, 2.5


@dataclass(slots=True)
class Places:
    """Positions (x, z) of objects, and the radius within which each counts as found."""

    found_within: list[tuple[float, float, float]] = field(default_factory=list)

    def recording(self, kind: Kind) -> Kind:
        """Wrap a kind so that the positions of its objects are recorded."""
        grow, least, most = kind

        def grow_and_record(
            rng: np.random.Generator, radius: float, x: float, z: float
        ) -> tuple[Visual, ...]:
            self.found_within.append((x, z, radius))
            return grow(rng, radius, x, z)

        return grow_and_record, least, most


def foreign_scene(rng: np.random.Generator, num_things: int, gap: float) -> tuple[Scene, Places]:
    """Make a world of random unknown objects, and their positions."""
    places = Places()
    kinds = [places.recording(kind) for kind in KINDS]
    return random_scene(rng, num_things, gap, kinds=kinds), places


def _ball(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    return (SphereVisual(centre=(x, 0.98 * radius, z), radius=radius, texture=_texture(rng)),)


def _rock(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    """Make overlapping lumps."""
    texture = _texture(rng)
    lumps = []
    for turn in np.radians(120.0) * np.arange(3):
        radii: Vector = tuple(radius * rng.uniform(0.5, 0.65, 3))
        place = 0.35 * radius * np.array([np.cos(turn), np.sin(turn)])
        centre = (x + place[0], 0.8 * radii[1], z + place[1])
        lumps.append(EllipsoidVisual(centre=centre, radii=radii, texture=texture))
    return tuple(lumps)


def _post(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    return (_upright((x, rng.uniform(5.0, 9.0), z), radius, _texture(rng)),)


def _box(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    turn, height, texture = rng.uniform(0.5, 1.0), rng.uniform(4.0, 8.0), _texture(rng)
    a, b = radius * np.cos(turn), radius * np.sin(turn)
    corners = _turned(rng, [(-a, -b), (a, -b), (a, b), (-a, b)], x, z)
    return tuple(_sheet(corners[n - 1], corners[n], height, texture) for n in range(4))


def _wall(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    start, end = _turned(rng, [(-radius, 0.0), (radius, 0.0)], x, z)
    return (_sheet(start, end, rng.uniform(5.0, 8.0), _texture(rng)),)


def _fence(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    height, texture = rng.uniform(4.0, 6.0), _texture(rng)
    places = np.arange(PALE_RADIUS - radius, radius, PALE_SPACING)
    row = _turned(rng, [(place, 0.0) for place in places], x, z)
    return tuple(_upright((px, height, pz), PALE_RADIUS, texture) for px, pz in row)


def _upright(upper_end: Vector, radius: float, texture: int) -> CylinderVisual:
    return CylinderVisual(
        radius_base=radius,
        radius_top=radius,
        height=upper_end[1],
        translation=upper_end,
        texture=texture,
    )


def _sheet(
    start: tuple[float, float], end: tuple[float, float], height: float, texture: int
) -> PolygonVisual:
    """Make an upright sheet between two positions, visible from both sides."""
    (ax, az), (bx, bz) = start, end
    u, v = np.hypot(bx - ax, bz - az) / TILE, height / TILE
    corners = [(ax, 0.0, az), (bx, 0.0, bz), (bx, height, bz), (ax, height, az)]
    uvs = [(0.0, 0.0), (u, 0.0), (u, v), (0.0, v)]
    return PolygonVisual(
        cull_back=False,
        texture=texture,
        vertices=tuple(
            Vertex(position=position, colour=WHITE, uv=uv)
            for position, uv in zip(corners, uvs, strict=True)
        ),
    )


def _turned(
    rng: np.random.Generator, places: list[tuple[float, float]], x: float, z: float
) -> list[tuple[float, float]]:
    """Rotate positions around (x, z) by a common random angle."""
    heading = rng.uniform(0.0, np.pi)
    cos, sin = float(np.cos(heading)), float(np.sin(heading))
    return [(x + cos * a - sin * b, z + sin * a + cos * b) for a, b in places]


def _texture(rng: np.random.Generator) -> int:
    return int(rng.integers(len(TEXTURES)))


KINDS: tuple[Kind, ...] = (
    (_ball, 3.5, 5.5),
    (_rock, 5.0, 7.0),
    (_post, 2.0, 5.0),
    (_box, 5.0, 7.0),
    (_wall, 10.0, 13.0),
    (_fence, 9.0, 12.0),
)
