"""The scenes that ship with recon, by name."""

from pathlib import Path

from recon.errors import InputError, check_path, nearest
from recon.world.textures import SHIPPED


def scene_names() -> list[str]:
    """Names of the scenes that ship."""
    return sorted(path.stem for path in SHIPPED.glob("*.scene"))


def find_scene(scene: str | Path) -> Path:
    """The geometry file of a scene: a file as it is, else the shipped scene of that name.

    Raises
    ------
    InputError
        If there is neither, with the nearest shipped name.
    """
    check_path(scene)
    path = Path(scene)
    if path.exists() and not path.is_dir():
        return path
    shipped = SHIPPED / f"{path}.scene"
    if path.name == str(path) and shipped.is_file():
        return shipped
    known = scene_names()
    near = nearest(str(scene), known)
    raise InputError(
        f"{scene} is neither a file nor a scene that ships ({', '.join(known)}; nearest: {near})"
    )
