"""Files that appear whole or not at all."""

import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary name beside `path`; what is written there takes its place at the end.

    The temporary name keeps the ending, as writers choose the format by it. What stood at `path`
    before is replaced in one step, and stays untouched where the block raises.
    """
    wanted = Path(path)
    if not wanted.parent.is_dir():
        # Said of the folder that was asked for, not of the temporary name.
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(wanted.parent))
    temporary = wanted.with_name(f".{secrets.token_hex(4)}-{wanted.name}")
    try:
        yield temporary
        temporary.replace(wanted)
    finally:
        temporary.unlink(missing_ok=True)
