"""Export of the shown rows as a file of any format."""

import io
import tempfile
import zipfile
from pathlib import Path

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


def archive(files: dict[str, bytes]) -> bytes:
    """Files by name as one archive; the same files yield the same bytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as zipped:
        for name, content in files.items():
            zipped.writestr(zipfile.ZipInfo(name), content)
    return stream.getvalue()
