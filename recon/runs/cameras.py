"""The cameras of the pairs of a run: cameras.json."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from recon.camera import StereoRig
from recon.errors import InputError
from recon.files.documents import read_json

CAMERAS = "cameras.json"


@dataclass(frozen=True, slots=True, kw_only=True)
class SeenCamera:
    """The rig of a pair, by the name of the pair."""

    name: str
    rig: StereoRig


def cameras_text(seen: Sequence[SeenCamera]) -> str:
    """The text of cameras.json: the distinct rigs, and the index of each pair's rig."""
    numbers = {rig: number for number, rig in enumerate(dict.fromkeys(one.rig for one in seen))}
    document = {
        "rigs": [asdict(rig) for rig in numbers],
        "pairs": [{"name": one.name, "rig": numbers[one.rig]} for one in seen],
    }
    return json.dumps(document, indent=1) + "\n"


def read_cameras(path: Path) -> list[SeenCamera]:
    """Read what `cameras_text` wrote.

    Raises
    ------
    InputError
        If the file is missing or damaged.
    """
    if not path.is_file():
        raise InputError(f"{path} is missing: only runs with a trajectory write it")
    document = read_json(path)
    try:
        rigs = [StereoRig(**rig) for rig in document["rigs"]]
        pairs = [(str(one["name"]), rigs[one["rig"]]) for one in document["pairs"]]
    except (KeyError, TypeError, IndexError, InputError) as error:
        raise InputError(f"{path} is damaged ({error!r:.80})") from error
    return [SeenCamera(name=name, rig=rig) for name, rig in pairs]
