"""An archive of several files."""

import io
import zipfile


def archive(files: dict[str, bytes]) -> bytes:
    """Files by name as one archive; the same files yield the same bytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as zipped:
        for name, content in files.items():
            zipped.writestr(zipfile.ZipInfo(name), content)
    return stream.getvalue()
