"""Description of a file or folder, recognised by its suffix and content."""

import importlib
from collections.abc import Callable
from pathlib import Path

from recon.errors import InputError
from recon.exports.formats import FORMATS
from recon.exports.partitions.store import is_partitioned
from recon.files import check_regular
from recon.manifest import MANIFEST
from recon.notices import collected_notices
from recon.runs.description.facts import Facts
from recon.world.library import find_scene, scene_names

# The describing function of each kind, imported on demand: some import a lot.
_RUN, _RECORDING, _POINTS = "runs:of_run", "recordings:of_recording", "points:of_points"
_IMAGE = "recordings:of_image"
_BY_ENDING = {
    ".scene": "recordings:of_scene",
    ".pfm": "recordings:of_disparity",
    ".xml": "recordings:of_calibration",
    ".json": "documents:of_json",
    ".toml": "documents:of_toml",
    ".yaml": "documents:of_yaml",
    ".yml": "documents:of_yaml",
    ".txt": "documents:of_text",
    ".csv": "documents:of_text",
    ".npz": "points:of_npz",
}
_IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".ppm", ".pgm", ".tga", ".webp")


def describe(path: Path) -> Facts:
    """Facts about anything that recon reads or writes, `kind` first, `warnings` last.

    The name of a scene that ships is described as its file.

    Raises
    ------
    InputError
        If `path` does not exist, or recon does not know its format.
    """
    if str(path) in scene_names() and not path.exists():
        path = find_scene(path)
    with collected_notices() as notices:
        try:
            facts = _describer(path)(path)
        except InputError as error:
            raise error if str(path) in str(error) else InputError(f"{path}: {error}") from error
    return facts | {"warnings": [notice.as_json() for notice in notices]}


def _describer(path: Path) -> Callable[[Path], Facts]:
    """The function that describes `path`."""
    place = _place(path)
    module, _, name = place.partition(":")
    found: Callable[[Path], Facts] = getattr(
        importlib.import_module(f"recon.runs.description.{module}"), name
    )
    return found


def _place(path: Path) -> str:
    if not path.exists():
        raise InputError(f"{path} does not exist")
    ending = path.suffix.lower()
    if path.is_dir():
        if ending == ".zarr" or is_partitioned(path):
            return _POINTS
        return _RUN if (path / MANIFEST).exists() else _RECORDING
    check_regular(path)
    if ending in _BY_ENDING:
        return _BY_ENDING[ending]
    if ending in _IMAGES and not _is_map(path):
        return _IMAGE
    if ending in FORMATS:
        return _POINTS
    if _is_recording(path):
        return _RECORDING
    what = f"has the ending {ending}, which recon neither reads nor writes"
    raise InputError(f"{path} {what if ending else 'has no ending, by which formats are told'}")


def _is_recording(path: Path) -> bool:
    from recon.sequences.open import find_recording

    return find_recording(path) is not None


def _is_map(path: Path) -> bool:
    """Test for an image of a nav2 map, with its description beside it."""
    beside = (path.with_suffix(ending) for ending in (".yaml", ".yml"))
    return path.suffix.lower() == ".pgm" and any(one.is_file() for one in beside)
