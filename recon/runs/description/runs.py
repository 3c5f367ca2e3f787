"""Descriptions of run folders."""

from pathlib import Path

from recon.errors import InputError
from recon.manifest import read_manifest
from recon.runs.description.documents import of_metrics, of_objects
from recon.runs.description.facts import Facts
from recon.runs.report import read_json

_OF_MANIFEST = ("command", "state", "error", "seed", "inputs", "versions")


def of_run(path: Path) -> Facts:
    """The origin of a run, its findings and its files."""
    manifest = read_manifest(path)
    facts: Facts = {"kind": "run"} | {name: manifest.get(name) for name in _OF_MANIFEST}
    for name, described in (("metrics.json", of_metrics), ("objects.json", of_objects)):
        if (path / name).is_file():
            found = read_json(path / name)
            if not isinstance(found, dict):
                raise InputError(f"{path / name} is damaged: a {type(found).__name__}")
            facts |= {key: value for key, value in described(found).items() if key != "kind"}
    facts["seconds"] = manifest.get("seconds")
    facts["files"] = sorted(
        str(file.relative_to(path)) for file in path.rglob("*") if file.is_file()
    )
    return facts
