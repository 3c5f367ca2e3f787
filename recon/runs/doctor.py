"""A check of this machine: libraries, rendering, caches."""

import importlib.metadata
import importlib.util
import platform
from dataclasses import dataclass

from recon.environment import kernel_folder
from recon.libraries import open3d_fault, rendering_fault
from recon.world.filament import filament_fault

EXTRAS = {
    "laspy": "las",
    "pye57": "e57",
    "pyoctomap": "octomap",
    "trimesh": "mesh",
    "pyarrow": "tables",
    "zarr": "tables",
    "fsspec": "tables",
    "rosbags": "ros",
    "nicegui": "app",
    "distributed": "cluster",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Result of one check."""

    name: str
    is_well: bool
    is_needed: bool
    word: str
    """Its version, or the remedy."""

    def as_json(self) -> dict[str, object]:
        """The finding as an entry of `recon doctor --json`."""
        return {
            "name": self.name,
            "ok": self.is_well,
            "needed": self.is_needed,
            "message": self.word,
        }


def examine() -> list[Finding]:
    """Check everything; a library that could kill the process is tried in a child."""
    return [
        _needed("python", None, platform.python_version()),
        _needed("open3d", open3d_fault(), importlib.metadata.version("open3d")),
        _needed("rendering", rendering_fault(), "without a screen"),
        _optional("filament", filament_fault(), "light and shadows"),
        _kernels(),
        *(_extra(*item) for item in EXTRAS.items()),
    ]


def _kernels() -> Finding:
    """Folder of compiled kernels; without one, every command compiles for half a minute."""
    folder = kernel_folder()
    cure = "no writable folder: every command compiles anew; set NUMBA_CACHE_DIR to a folder"
    return _optional("kernels", None if folder else cure, f"kept in {folder}")


def _needed(name: str, fault: str | None, word: str) -> Finding:
    return Finding(name=name, is_well=fault is None, is_needed=True, word=fault or word)


def _optional(name: str, fault: str | None, word: str) -> Finding:
    return Finding(name=name, is_well=fault is None, is_needed=False, word=fault or word)


def _extra(module: str, extra: str) -> Finding:
    if importlib.util.find_spec(module) is None:
        word = f"pip install 'recon-stereo[{extra}]'"
        return Finding(name=module, is_well=False, is_needed=False, word=word)
    word = importlib.metadata.version(module)
    return Finding(name=module, is_well=True, is_needed=False, word=word)
