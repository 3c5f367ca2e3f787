"""What this machine has of the things recon needs."""

import importlib.metadata
import importlib.util
import platform
from dataclasses import dataclass

from recon.errors import MissingLibraryError
from recon.libraries import load_open3d, rendering_fault

EXTRAS = {
    "laspy": "las",
    "pyoctomap": "octomap",
    "trimesh": "mesh",
    "pyarrow": "tables",
    "zarr": "tables",
    "rosbags": "ros",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One thing that was looked at."""

    name: str
    is_well: bool
    is_needed: bool
    word: str
    """Its version, or what cures it."""

    def as_json(self) -> dict[str, object]:
        """The finding as `recon doctor --json` has it."""
        return {
            "name": self.name,
            "ok": self.is_well,
            "needed": self.is_needed,
            "message": self.word,
        }


def examine() -> list[Finding]:
    """Look at everything; a library that could kill the process is tried in a child."""
    python = Finding(name="python", is_well=True, is_needed=True, word=platform.python_version())
    return [python, _open3d(), _rendering(), *(_extra(*item) for item in EXTRAS.items())]


def _open3d() -> Finding:
    try:
        word = str(load_open3d().__version__)
    except MissingLibraryError as error:
        return Finding(name="open3d", is_well=False, is_needed=True, word=str(error))
    return Finding(name="open3d", is_well=True, is_needed=True, word=word)


def _rendering() -> Finding:
    fault = rendering_fault()
    return Finding(
        name="rendering", is_well=fault is None, is_needed=True, word=fault or "without a screen"
    )


def _extra(module: str, extra: str) -> Finding:
    if importlib.util.find_spec(module) is None:
        word = f"pip install 'recon[{extra}]'"
        return Finding(name=module, is_well=False, is_needed=False, word=word)
    word = importlib.metadata.version(module)
    return Finding(name=module, is_well=True, is_needed=False, word=word)
