"""Light on surfaces, as OpenGL's fixed pipeline has it: a colour a corner (Gouraud)."""

import dataclasses

import numpy as np

from recon.world.solids import Triangles
from recon.world.visuals import Shader

SUN = np.array([0.36, 0.80, 0.48])
"""Direction to the light in the world, of length 1."""

PLAIN = Shader(
    ambient=(0.45, 0.45, 0.45, 1.0),
    diffuse=(0.55, 0.55, 0.55, 1.0),
    specular=(0.0, 0.0, 0.0, 1.0),
    emissive=(0.0, 0.0, 0.0, 1.0),
    shininess=0.0,
)
"""The material of a visual that has no shader: it keeps its own colour."""


def painted(part: Triangles, shader: Shader | None) -> Triangles:
    """The part in its shader's colours, for a renderer that makes the light itself."""
    if shader is None:
        return part
    colour = np.add(np.add(shader.ambient, shader.diffuse), shader.emissive)[:3]
    paint = np.broadcast_to(np.clip(colour, 0.0, 1.0), part.colours.shape)
    return dataclasses.replace(part, colours=paint)


def lit(part: Triangles, shader: Shader | None) -> Triangles:
    """The part with its corners' colours under the sun.

    A shader takes the place of the part's own colours. Highlights are left out: they move with
    the camera, and two cameras would see them at a depth where nothing is.
    """
    material = shader or PLAIN
    facing = np.maximum(0.0, part.normals @ SUN)[..., None]
    ambient, diffuse, emissive = (
        np.array(colour[:3]) for colour in (material.ambient, material.diffuse, material.emissive)
    )
    light = np.clip(emissive + ambient + facing * diffuse, 0.0, 1.0)
    return dataclasses.replace(part, colours=light if shader else light * part.colours)
