"""A file or folder recognised by its ending and content, and described."""

from pathlib import Path

from recon.errors import InputError
from recon.exports.formats import FORMATS
from recon.files import check_regular
from recon.notices import collected_notices
from recon.runfolder import MANIFEST
from recon.runs.description.documents import of_json, of_text, of_toml, of_yaml
from recon.runs.description.facts import Facts
from recon.runs.description.points import of_npz, of_points
from recon.runs.description.recordings import (
    of_calibration,
    of_disparity,
    of_image,
    of_recording,
    of_scene,
)  # fmt: skip
from recon.runs.description.runs import of_run
from recon.sequences.images import ENDINGS
from recon.sequences.readers.bag import is_bag
from recon.sequences.readers.video import ENDINGS as VIDEO_ENDINGS

_BY_ENDING = {
    ".scene": of_scene, ".pfm": of_disparity, ".json": of_json, ".toml": of_toml,
    ".yaml": of_yaml, ".yml": of_yaml, ".xml": of_calibration, ".npz": of_npz, ".txt": of_text,
    ".csv": of_text,
}  # fmt: skip


def describe(path: Path) -> Facts:
    """Facts about anything that recon reads or writes, `kind` first, `warnings` last.

    Raises
    ------
    InputError
        Where nothing is at `path`, or nothing that recon knows.
    """
    with collected_notices() as notices:
        try:
            facts = _described(path)
        except InputError as error:
            raise error if str(path) in str(error) else InputError(f"{path}: {error}") from error
    return facts | {"warnings": [notice.as_json() for notice in notices]}


def _described(path: Path) -> Facts:
    if not path.exists():
        raise InputError(f"{path} does not exist")
    ending = path.suffix.lower()
    if path.is_dir() and ending != ".zarr":
        return of_run(path) if (path / MANIFEST).exists() else of_recording(path)
    if path.is_dir():
        return of_points(path)
    check_regular(path)
    if is_bag(path) or ending in VIDEO_ENDINGS:
        return of_recording(path)
    if ending in _BY_ENDING:
        return _BY_ENDING[ending](path)
    if ending in ENDINGS and not _is_map(path):
        return of_image(path)
    if ending in FORMATS:
        return of_points(path)
    raise InputError(f"{path}: the ending {ending!r} is not one that recon reads or writes")


def _is_map(path: Path) -> bool:
    """Whether an image is that of a nav2 map, described beside it."""
    beside = (path.with_suffix(ending) for ending in (".yaml", ".yml"))
    return path.suffix.lower() == ".pgm" and any(one.is_file() for one in beside)
