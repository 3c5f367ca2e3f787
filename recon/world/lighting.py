"""Lighting of surfaces as in OpenGL's fixed pipeline: one colour per corner (Gouraud)."""

import dataclasses

import numpy as np

from recon.world.solids import Triangles
from recon.world.visuals import Shader

SUN = np.array([0.36, 0.80, 0.48])
"""Direction to the light in the world, unit length."""

PLAIN = Shader(
    ambient=(0.45, 0.45, 0.45, 1.0),
    diffuse=(0.55, 0.55, 0.55, 1.0),
    specular=(0.0, 0.0, 0.0, 1.0),
    emissive=(0.0, 0.0, 0.0, 1.0),
    shininess=0.0,
)
"""The material of a visual without a shader, which keeps its own colour."""


def painted(part: Triangles, shader: Shader | None) -> Triangles:
    """The part in its shader's colours, for a renderer with its own lighting."""
    if shader is None:
        return part
    colour = np.add(np.add(shader.ambient, shader.diffuse), shader.emissive)[:3]
    paint = np.broadcast_to(np.clip(colour, 0.0, 1.0), part.colours.shape)
    return dataclasses.replace(part, colours=paint)


def lit(part: Triangles, shader: Shader | None) -> Triangles:
    """The part with its corners lit by the sun.

    A shader replaces the part's own colours. Specular highlights are omitted: they move with the
    camera, so stereo would see them at a wrong depth.
    """
    material = shader or PLAIN
    facing = np.maximum(0.0, part.normals @ SUN)[..., None]
    ambient, diffuse, emissive = (
        np.array(colour[:3]) for colour in (material.ambient, material.diffuse, material.emissive)
    )
    light = np.clip(emissive + ambient + facing * diffuse, 0.0, 1.0)
    return dataclasses.replace(part, colours=light if shader else light * part.colours)
