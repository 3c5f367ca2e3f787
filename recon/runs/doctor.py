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
class Check:
    """Result of one check."""

    name: str
    is_ok: bool
    is_needed: bool
    message: str
    """Its version, or the remedy."""

    def as_json(self) -> dict[str, object]:
        """The check as an entry of `recon doctor --json`."""
        return {
            "name": self.name,
            "ok": self.is_ok,
            "needed": self.is_needed,
            "message": self.message,
        }


def examine() -> list[Check]:
    """Check everything; a library that could kill the process is tried in a child."""
    return [
        _needed("python", None, platform.python_version()),
        _needed("open3d", open3d_fault(), importlib.metadata.version("open3d")),
        _needed("rendering", rendering_fault(), "without a screen"),
        _optional("filament", filament_fault(), "light and shadows"),
        _kernels(),
        *(_extra(*item) for item in EXTRAS.items()),
    ]


def _kernels() -> Check:
    """Folder of compiled kernels; without one, every command compiles for half a minute."""
    folder = kernel_folder()
    remedy = "no writable folder: every command compiles anew; set NUMBA_CACHE_DIR to a folder"
    return _optional("kernels", None if folder else remedy, f"kept in {folder}")


def _needed(name: str, fault: str | None, detail: str) -> Check:
    return Check(name=name, is_ok=fault is None, is_needed=True, message=fault or detail)


def _optional(name: str, fault: str | None, detail: str) -> Check:
    return Check(name=name, is_ok=fault is None, is_needed=False, message=fault or detail)


def _extra(module: str, extra: str) -> Check:
    if importlib.util.find_spec(module) is None:
        return _optional(module, f"pip install 'recon-stereo[{extra}]'", "")
    return _optional(module, None, importlib.metadata.version(module))
