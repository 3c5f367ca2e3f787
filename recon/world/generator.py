"""Random worlds: apple trees, pine trees and cottages of many sizes and looks."""

from collections.abc import Callable, Sequence

import numpy as np

from recon.errors import InputError
from recon.geometry import Array
from recon.world.furniture import TEXTURES, bench, house, lamp_post, post, table
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

CROWNS, TRUNKS = ("grass", "leaves"), ("wood", "bubinga", "earth")
WALLS, ROOFS = ("brick", "marble", "earth"), ("roof", "cobra")

START_ROOM = 12.0
"""Radius around the start that stays free, so that the agent can turn and walk."""

TIP_RADIUS = 1.0
"""Radius of the upper end of a cone, as in the thesis's worlds."""

GROUND_REACH = 500.0
GROUND_RGBA = (0.5, 0.5, 0.0, 0.0)

_TRIES = 2000


def random_scene(
    rng: np.random.Generator,
    num_objects: int,
    gap: float,
    *,
    floor_size: float = 200.0,
    kinds: "Sequence[Kind] | None" = None,
) -> Scene:
    """A world of objects at least `gap` apart, on plain ground.

    Parameters
    ----------
    rng : Generator
    num_objects : int
    gap : float
        Minimum distance between two objects, and to the floor's border, world units.
    floor_size : float
        Side of the floor around the origin, world units.
    kinds : sequence of Kind, optional
        By default the thesis's three (`KINDS`).

    Raises
    ------
    InputError
        If `num_objects` objects do not fit that far apart.
    """
    chosen = KINDS if kinds is None else kinds
    circles = [np.array([0.0, 0.0, START_ROOM - gap])]
    visuals: list[Visual] = []
    for _ in range(num_objects):
        grow, least, most = chosen[int(rng.integers(len(chosen)))]
        radius = rng.uniform(least, most)
        reach = floor_size / 2.0 - radius - gap
        place = _free_place(rng, np.array(circles), radius + gap, reach)
        if place is None:
            raise InputError(
                f"num_objects is {num_objects} and gap is {gap}, but only {len(circles) - 1} fit "
                f"on a floor of side {floor_size}: fewer objects or a smaller gap are needed"
            )
        circles.append(np.append(place, radius))
        visuals.extend(grow(rng, radius, float(place[0]), float(place[1])))
    names = tuple(f"textures/{name}.tga" for name in TEXTURES)
    return Scene(textures=names, visuals=(*visuals, plain_ground()))


def plain_ground() -> PolygonVisual:
    """The thesis's ground: olive, without a texture, far wider than the floor."""
    corners = ((-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0))
    return PolygonVisual(
        cull_back=True,
        vertices=tuple(
            Vertex(
                position=(GROUND_REACH * x, 0.0, GROUND_REACH * z),
                colour=GROUND_RGBA,
                uv=(0.0, 0.0),
            )
            for x, z in corners
        ),
    )


def _free_place(
    rng: np.random.Generator, circles: Array, distance: float, reach: float
) -> Array | None:
    """A random x, z at least `distance` from all circles (x, z, radius); None if none is found."""
    if reach <= 0:
        return None
    place: Array
    for place in rng.uniform(-reach, reach, size=(_TRIES, 2)):
        apart = np.hypot(*(circles[:, :2] - place).T) - circles[:, 2]
        if apart.min() >= distance:
            return place
    return None


def _apple_tree(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    height = rng.uniform(5.0, 10.0)
    trunk = post((x, height, z), radius * rng.uniform(0.3, 0.5), height, _pick(rng, TRUNKS))
    texture = _pick(rng, CROWNS)
    if rng.random() < 0.7:
        centre = (x, height + radius, z)
        return SphereVisual(centre=centre, radius=radius, texture=texture), trunk
    upright = radius * rng.uniform(0.75, 1.3)
    centre = (x, height + upright, z)
    return EllipsoidVisual(centre=centre, radii=(radius, upright, radius), texture=texture), trunk


def _pine_tree(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    height, crown = rng.uniform(4.0, 9.0), rng.uniform(6.0, 11.0)
    trunk = post((x, height, z), radius * rng.uniform(0.2, 0.4), height, _pick(rng, TRUNKS))
    return _cone((x, height + crown, z), radius, crown, _pick(rng, CROWNS)), trunk


def _cottage(rng: np.random.Generator, radius: float, x: float, z: float) -> tuple[Visual, ...]:
    height, roof = rng.uniform(5.0, 9.0), rng.uniform(3.0, 5.0)
    walls = post((x, height, z), radius * rng.uniform(0.85, 1.0), height, _pick(rng, WALLS))
    return _cone((x, height + roof, z), radius, roof, _pick(rng, ROOFS)), walls


def _cone(upper_end: Vector, radius: float, height: float, texture: int) -> CylinderVisual:
    return CylinderVisual(
        radius_base=TIP_RADIUS,
        radius_top=radius,
        height=height,
        translation=upper_end,
        texture=texture,
    )


def _pick(rng: np.random.Generator, names: Sequence[str]) -> int:
    return TEXTURES.index(names[int(rng.integers(len(names)))])


Grow = Callable[[np.random.Generator, float, float, float], tuple[Visual, ...]]

Kind = tuple[Grow, float, float]

KINDS: tuple[Kind, ...] = (
    (_apple_tree, 3.0, 6.0),
    (_pine_tree, 4.0, 8.0),
    (_cottage, 4.0, 8.0),
)
"""The kinds of objects, with their minimum and maximum radius, world units."""

COMPOSITES: tuple[Kind, ...] = (
    (house, 6.0, 9.0),
    (table, 4.5, 6.5),
    (bench, 4.0, 5.5),
    (lamp_post, 1.4, 2.0),
)
"""The same for composite objects."""
