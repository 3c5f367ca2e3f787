"""The folder of a batch, in which an earlier batch outlives every failure of a new one."""

import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from recon.errors import InputError
from recon.files.documents import read_json
from recon.locks import locked
from recon.runfolder import EarlierRun, check_flags, check_none_inside

SUMMARY = "summary.json"
"""The file that every batch writes first and last, which identifies its folder."""


@contextmanager
def opened(
    path: Path, inputs: Iterable[Path], *, overwrite: bool, resume: bool
) -> Iterator[EarlierRun]:
    """Create the folder, or take up the one to resume; no other process can open it meanwhile.

    An earlier batch that is replaced is kept beside the new one until the block removes it. If the
    block fails before any job has a folder, everything is as before.

    Raises
    ------
    InputError
        If the folder contains anything but a batch, or a batch and neither flag is given, if an
        input would be replaced, or if another process has it open.
    """
    check_flags(path, overwrite=overwrite, resume=resume)
    path.parent.mkdir(parents=True, exist_ok=True)
    busy = f"{path} is being written by another batch; wait for it, or give another -o"
    earlier = EarlierRun(path, _is_done)
    with locked(path, busy):
        _check_batch(path)
        if overwrite and path.exists():
            check_none_inside(path, inputs)
            earlier.put_aside()
        is_new = not path.exists()
        try:
            path.mkdir(exist_ok=True)
            (path / SUMMARY).touch()
            yield earlier
        except BaseException:
            if is_new and not any(one.is_dir() for one in path.glob("*")):
                _undo(earlier)
            raise


def _check_batch(path: Path) -> None:
    if path.exists() and not path.is_dir():
        raise InputError(f"{path} is not a folder; give another -o")
    is_filled = path.exists() and any(path.iterdir())
    if is_filled and not (path / SUMMARY).exists():
        raise InputError(f"{path} is not the folder of a batch; give another -o")


def _undo(earlier: EarlierRun) -> None:
    """Put the earlier batch back if there is one, else remove the folder."""
    if earlier.place.exists():
        earlier.restore()
    else:
        shutil.rmtree(earlier.path, ignore_errors=True)


def _is_done(folder: Path) -> bool:
    """True for a batch that ended without a failed job."""
    try:
        document = read_json(folder / SUMMARY)
    except (OSError, InputError):
        return False
    return isinstance(document, dict) and document.get("num_failed") == 0
