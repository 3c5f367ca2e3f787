"""Composite objects of planes and bars: a house, a table, a bench, a lamp post."""

from collections.abc import Sequence

import numpy as np

from recon.geometry import Array, rotation_about_y
from recon.world.visuals import (
    CylinderVisual,
    PolygonVisual,
    SphereVisual,
    Vector,
    Vertex,
    Visual,
)

TEXTURES = ("grass", "leaves", "wood", "bubinga", "earth", "brick", "marble", "roof", "cobra")
"""In the order of the visuals' texture indices."""
BOARDS, WALLS, ROOFS, POSTS, LAMPS = (2, 3), (5, 6), (7, 8), (2, 4), (6, 8)
TILE = 4.0
"""Side of a texture tile on a plane, world units."""
WHITE = (1.0, 1.0, 1.0, 1.0)
LEG_RADIUS = 0.5
INSET = 0.9
"""Distance of a leg's axis from the edges of its board."""


def house(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    """Four walls under a gabled roof, within a radius."""
    half = radius * np.array([np.cos(0.65), np.sin(0.65)])
    height, rise = rng.uniform(4.0, 6.0), rng.uniform(3.5, 5.5)
    T = _Frame(rng, x, z)
    walls, roof = _one_of(rng, WALLS), _one_of(rng, ROOFS)
    a, b = half
    corners = [(-a, -b), (a, -b), (a, b), (-a, b)]
    sides = [
        T.polygon([(*p, 0.0), (*q, 0.0), (*q, height), (*p, height)], walls)
        for p, q in zip(corners, [*corners[1:], corners[0]], strict=True)
    ]
    gables = [
        T.polygon([(s * a, -b, height), (s * a, b, height), (s * a, 0.0, height + rise)], walls)
        for s in (-1.0, 1.0)
    ]
    slopes = [
        T.polygon(
            [(-a, s * b, height), (a, s * b, height), (a, 0.0, height + rise),
             (-a, 0.0, height + rise)], roof,
        )
        for s in (-1.0, 1.0)
    ]  # fmt: skip
    return (*sides, *gables, *slopes)


def table(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    """A board on four legs."""
    a, b = radius * np.array([np.cos(0.6), np.sin(0.6)])
    height = rng.uniform(3.2, 4.2)
    T = _Frame(rng, x, z)
    top = T.polygon(_board(a, b, height), _one_of(rng, BOARDS))
    return (top, *_legs(T, a, b, height, _one_of(rng, BOARDS)))


def bench(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    """A seat on four legs, and a back."""
    a, b = radius * np.array([np.cos(0.35), np.sin(0.35)])
    height, rise = rng.uniform(2.2, 2.8), rng.uniform(2.5, 3.5)
    T = _Frame(rng, x, z)
    texture = _one_of(rng, BOARDS)
    seat = T.polygon(_board(a, b, height), texture)
    top = height + rise
    back = T.polygon([(-a, -b, height), (a, -b, height), (a, -b, top), (-a, -b, top)], texture)
    return (seat, back, *_legs(T, a, b, height, texture))


def lamp_post(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    """A lamp on a slender post."""
    height = rng.uniform(9.0, 12.0)
    lamp = SphereVisual(centre=(x, height + radius, z), radius=radius, texture=_one_of(rng, LAMPS))
    return lamp, post((x, height, z), rng.uniform(0.4, 0.6), height, _one_of(rng, POSTS))


class _Frame:
    """A rotated frame on the floor, with corners given as (along, across, height)."""

    def __init__(self, rng: np.random.Generator, x: float, z: float) -> None:
        self.rotation = rotation_about_y(float(rng.uniform(0.0, np.pi)))
        self.origin = np.array([x, 0.0, z])

    def place(self, along: float, across: float, height: float) -> Array:
        """World coordinates (3,)."""
        placed: Array = self.origin + self.rotation @ np.array([along, height, across])
        return placed

    def polygon(self, corners: Sequence[Sequence[float]], texture: int) -> PolygonVisual:
        """A plane seen from both sides, its texture along its first edge."""
        places = np.array([self.place(*corner) for corner in corners])
        along = places[1] - places[0]
        along /= np.linalg.norm(along)
        normal = np.cross(along, places[2] - places[0])
        across = np.cross(normal / np.linalg.norm(normal), along)
        uv = (places - places[0]) @ np.stack([along, across]).T / TILE
        return PolygonVisual(
            cull_back=False,
            texture=texture,
            vertices=tuple(
                Vertex(position=_vector(place), colour=WHITE, uv=(float(u), float(v)))
                for place, (u, v) in zip(places, uv, strict=True)
            ),
        )


def _board(a: float, b: float, height: float) -> list[tuple[float, float, float]]:
    return [(-a, -b, height), (a, -b, height), (a, b, height), (-a, b, height)]


def _legs(T: _Frame, a: float, b: float, height: float, texture: int) -> list[CylinderVisual]:
    inset_a, inset_b = a - INSET, max(b - INSET, LEG_RADIUS)
    ends = [T.place(i * inset_a, j * inset_b, height) for i in (-1, 1) for j in (-1, 1)]
    return [post(_vector(end), LEG_RADIUS, height, texture) for end in ends]


def post(upper_end: Vector, radius: float, height: float, texture: int) -> CylinderVisual:
    """An upright cylinder below its upper end."""
    return CylinderVisual(
        radius_base=radius,
        radius_top=radius,
        height=height,
        translation=upper_end,
        texture=texture,
    )


def _vector(place: Array) -> Vector:
    x, y, z = place.tolist()
    return x, y, z


def _one_of(rng: np.random.Generator, textures: Sequence[int]) -> int:
    return textures[int(rng.integers(len(textures)))]
