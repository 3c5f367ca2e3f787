"""Export of the shown rows as a file of any format."""

import tempfile
from pathlib import Path

from recon.app.archive import archive
from recon.app.layers import Data
from recon.exports.formats import FORMATS, write

ENDINGS = tuple(FORMATS.names())


def packed(data: Data, stem: str, ending: str) -> tuple[str, bytes]:
    """Name and content of a file; formats of several files are one archive.

    Raises
    ------
    InputError
        If the format cannot hold the data.
    """
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / f"{stem}{ending}"
        write(data, target)
        files = sorted(path for path in Path(folder).rglob("*") if path.is_file())
        if files == [target]:
            return target.name, target.read_bytes()
        return f"{stem}{ending}.zip", archive({
            path.relative_to(folder).as_posix(): path.read_bytes() for path in files
        })  # fmt: skip
