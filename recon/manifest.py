"""The manifest of a run folder: what determined the run, its state, digests of its files."""

import hashlib
import importlib.metadata
import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from recon.errors import InputError
from recon.files.documents import read_json

MANIFEST = "manifest.json"
PARTIAL = "partial"
"""Subfolder of what is only needed to resume a run."""
KEYS = {"command", "seed", "settings_sha256", "inputs", "state"}
"""Keys that every manifest has."""
LIBRARIES = ("recon-stereo", "numpy", "scipy", "opencv-python-headless", "open3d", "numba")


@dataclass(frozen=True, slots=True, kw_only=True)
class RunPlan:
    """Everything that determines a run: the same plan yields the same bytes."""

    command: str
    arguments: dict[str, Any] = field(default_factory=dict)
    """Arguments of the command besides its inputs and settings, as JSON values."""
    settings_toml: str
    seed: int
    inputs: tuple[Path, ...]
    """Files and folders that are read; a folder stands for all files in it."""

    def identity(self) -> dict[str, Any]:
        """Everything that must match before a run is resumed."""
        return {
            "command": self.command,
            "arguments": json.loads(json.dumps(self.arguments)),
            "seed": self.seed,
            "settings_sha256": hashlib.sha256(self.settings_toml.encode()).hexdigest(),
            "inputs": [{"name": p.name, "sha256": digest(p)} for p in self.inputs],
        }


def read_manifest(path: Path) -> dict[str, Any]:
    """The manifest of a run folder.

    Raises
    ------
    InputError
        If `path` is not a run folder.
    """
    try:
        document = read_json(path / MANIFEST)
    except (OSError, InputError) as error:
        raise InputError(f"{path} is not a run folder: its {MANIFEST} cannot be read") from error
    if not isinstance(document, dict) or not document.keys() >= KEYS:
        raise InputError(f"{path} is not a run folder: its {MANIFEST} was not written by recon")
    return document


def input_paths(manifest: Mapping[str, Any]) -> list[Path]:
    """Paths of the inputs at the time of the run."""
    return [Path(path) for path in manifest.get("input_paths", [])]


def is_finished(path: Path) -> bool:
    """True if a folder contains a finished run."""
    try:
        return bool(read_manifest(path)["state"] == "finished")
    except InputError:
        return False


def outputs(path: Path) -> dict[str, str]:
    """Digests of the files of a run by their names in it, without the manifest and partial data."""
    files = {
        file.relative_to(path): file
        for file in sorted(path.rglob("*"))
        if file.is_file() and file.name != MANIFEST
    }
    return {
        name.as_posix(): digest(file) for name, file in files.items() if PARTIAL not in name.parts
    }


def digest(path: Path) -> str:
    """SHA-256 of a file, as printed by `sha256sum`; for a folder, of the listing of its files."""
    if path.is_dir():
        files = sorted(file for file in path.rglob("*") if file.is_file())
        listing = "".join(f"{digest(f)}  {f.relative_to(path).as_posix()}\n" for f in files)
        return hashlib.sha256(listing.encode()).hexdigest()
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def versions() -> dict[str, str]:
    """Versions of Python and of the libraries that affect the numbers of a run."""
    found = {"python": platform.python_version()}
    return found | {name: importlib.metadata.version(name) for name in LIBRARIES}
