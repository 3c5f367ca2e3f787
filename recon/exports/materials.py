"""Materials of OBJ files (Wavefront's .mtl): one plain colour each."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.files import atomic_path
from recon.files.documents import read_text
from recon.notices import notify
from recon.records import Mesh

Colour = tuple[float, float, float]
"""Shares of red, green and blue."""

MAX_BYTES = 1 << 24
_LEVELS = 16
"""Levels per channel of the colours of triangles: limits the number of materials."""


def painted(
    num_vertices: int,
    faces: Sequence[NDArray[np.int64]],
    materials: Sequence[str | None],
    colours: dict[str, Colour],
) -> NDArray[np.uint8] | None:
    """Vertex colours (V, 3) from the materials of their faces; None if a vertex has none.

    Where materials meet, a vertex takes the last one.
    """
    shares = np.full((num_vertices, 3), np.nan)
    for face, material in zip(faces, materials, strict=True):
        if material in colours:
            shares[face] = colours[material]
    if np.isnan(shares).any():
        return None
    return np.rint(255.0 * shares).astype(np.uint8)


def read_colours(path: Path, names: Iterable[str]) -> dict[str, Colour]:
    """The colours of the material files that `path` names; missing ones cause a notice."""
    found: dict[str, Colour] = {}
    for name in dict.fromkeys(names):
        file = path.parent / name
        if Path(name).is_absolute() or ".." in Path(name).parts or not file.is_file():
            notify("colour-missing", f"{path}: its material file {name!r} is not beside it")
            continue
        found |= dict(_colours(file))
    return found


def _colours(file: Path) -> Iterator[tuple[str, Colour]]:
    material = ""
    for line in read_text(file, MAX_BYTES).splitlines():
        key, _, value = line.strip().partition(" ")
        if key == "newmtl":
            material = value.strip()
        elif key == "map_Kd":
            notify("colour-missing", f"{file}: textures are not read, only plain colours")
        elif key == "Kd":
            yield material, _colour(file, value)


def _colour(file: Path, text: str) -> Colour:
    try:
        red, green, blue = (float(word) for word in text.split())
    except ValueError:
        raise InputError(f"{file}: Kd is {text[:40]!r}, but three numbers are needed") from None
    if not all(0.0 <= share <= 1.0 for share in (red, green, blue)):
        raise InputError(f"{file}: Kd is {text[:40]!r}, but shares of 0 to 1 are needed")
    return red, green, blue


def material_names(mesh: Mesh) -> list[str]:
    """A material per triangle, named by its colour: the rounded mean of its corners."""
    assert mesh.colours is not None
    means = mesh.colours[mesh.triangles].mean(axis=1)
    levels = np.rint(means / 255.0 * (_LEVELS - 1)).astype(int) * 255 // (_LEVELS - 1)
    return [f"colour_{red:02x}{green:02x}{blue:02x}" for red, green, blue in levels.tolist()]


def write_materials(path: Path, names: Iterable[str]) -> None:
    """Write the materials named by `material_names`."""
    with atomic_path(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        for name in sorted(set(names)):
            shares = (byte / 255.0 for byte in bytes.fromhex(name[-6:]))
            file.write(f"newmtl {name}\nKd {' '.join(f'{share:.4f}' for share in shares)}\n")
