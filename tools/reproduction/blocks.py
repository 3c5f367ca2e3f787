"""Painted blocks on a floor: the stand-in for the blocks pairs of CMU."""

from collections.abc import Iterator

import numpy as np

from recon.world.visuals import PolygonVisual, Scene, Vertex

TEXTURES = (
    "textures/earth.png",
    "textures/checker.png",
    "textures/brick.png",
    "textures/wood.png",
    "textures/bubinga.png",
)
BLOCKS = (
    # x, z, width, height, depth, turn in degrees, texture
    (-4.5, -3.0, 3.0, 3.0, 3.0, 20.0, 1),
    (0.5, -1.0, 2.5, 2.0, 2.5, -15.0, 2),
    (4.5, -4.0, 3.0, 4.5, 2.0, 35.0, 3),
    (0.0, -7.0, 6.0, 3.0, 2.0, 5.0, 4),
    (-2.0, 3.0, 2.5, 1.4, 1.4, 40.0, 4),
)
FACES = ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7))
"""Corners of the four sides and the top."""
UV = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
GREY = (0.5, 0.5, 0.5, 1.0)


def blocks_scene() -> Scene:
    """Make the scene of blocks on a floor."""
    floor = [(-15.0, 0.0, -15.0), (-15.0, 0.0, 15.0), (15.0, 0.0, 15.0), (15.0, 0.0, -15.0)]
    visuals = [_quad(floor, 0, 3.0)]
    for block in BLOCKS:
        visuals.extend(_quad(corners, block[6], 1.0) for corners in _faces(*block[:6]))
    return Scene(textures=TEXTURES, visuals=tuple(visuals))


def _faces(
    x: float, z: float, width: float, height: float, depth: float, turn_deg: float
) -> Iterator[list[tuple[float, float, float]]]:
    """List the corners of the sides and the top of a block."""
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    plan = [(-1, 1), (1, 1), (1, -1), (-1, -1)]
    corners = []
    for y in (0.0, height):
        for a, b in plan:
            u, w = a * width / 2, b * depth / 2
            corners.append((float(x + c * u + s * w), y, float(z - s * u + c * w)))
    yield from ([corners[i] for i in face] for face in FACES)


def _quad(corners: list[tuple[float, float, float]], texture: int, repeats: float) -> PolygonVisual:
    vertices = tuple(
        Vertex(position=corner, colour=GREY, uv=(u * repeats, v * repeats))
        for corner, (u, v) in zip(corners, UV, strict=True)
    )
    return PolygonVisual(cull_back=False, texture=texture, vertices=vertices)
