"""What a finished run says of itself."""

import json
from pathlib import Path
from typing import Any

from recon.errors import InputError


def read_json(path: Path) -> Any:
    """A JSON file of a run folder.

    Raises
    ------
    InputError
        Where it is not there or is no JSON.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(f"{path} is missing; is {path.parent} a finished run?") from error
    except ValueError as error:
        raise InputError(f"{path}: {error}, but JSON is needed") from error


def read_report(run_path: Path) -> dict[str, Any]:
    """The metrics of a run with its folder and its objects."""
    metrics = read_json(run_path / "metrics.json")
    objects = read_json(run_path / "objects.json")
    if not (isinstance(metrics, dict) and isinstance(objects, dict) and "objects" in objects):
        raise InputError(f"{run_path} holds damaged metrics.json or objects.json")
    return {"run": str(run_path)} | metrics | {"objects": objects["objects"]}
