"""Limits on input files: regular files, UTF-8 names, memory."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from recon.errors import InputError, check_path
from recon.files.atomic import PathLike

_GIGABYTE = 1 << 30

_memory: ContextVar[int] = ContextVar("recon_memory", default=4 * _GIGABYTE)
_goes_outside: ContextVar[bool] = ContextVar("recon_goes_outside", default=False)


def check_regular(path: PathLike) -> None:
    """Raise unless `path` is a regular file whose name can be written as text.

    Raises
    ------
    FileNotFoundError
        If it does not exist.
    InputError
        For a folder, a pipe or device (possibly endless), or a name that is not UTF-8, which
        crashes compiled libraries.
    """
    check_name(path)
    mode = Path(path).stat().st_mode
    if not stat.S_ISREG(mode):
        kind = "folder" if stat.S_ISDIR(mode) else "pipe or device"
        raise InputError(f"{path} is a {kind}, but a file is needed")


def check_name(path: PathLike) -> None:
    """Raise `InputError` unless it is a path whose name is UTF-8."""
    check_path(path)
    try:
        os.fspath(path).encode()
    except UnicodeEncodeError as error:
        shown = os.fsencode(path).decode("utf-8", "backslashreplace")
        raise InputError(f"{shown}: its name is not UTF-8; rename it") from error


def check_target(path: PathLike, *, overwrite: bool, may_be_folder: bool = False) -> None:
    """Raise `InputError` if a file cannot be written: before the work, not after it.

    Parameters
    ----------
    path : path
    overwrite : bool
        Replace what exists.
    may_be_folder : bool
        What is written is a folder, or may be one.
    """
    check_path(path)
    target = Path(path)
    if not overwrite and target.exists():
        raise InputError(f"{path} exists; give --overwrite or another name")
    if may_be_folder:
        return
    if target.is_dir():
        raise InputError(f"{path} is a folder, but a file is needed")
    if not target.parent.is_dir():
        raise InputError(f"{target.parent} is not a folder, but that of {path} is needed")


@contextmanager
def memory_limit(num_bytes: int) -> Iterator[None]:
    """Limit files read in this context to `num_bytes` of unpacked data."""
    token = _memory.set(num_bytes)
    try:
        yield
    finally:
        _memory.reset(token)


@contextmanager
def outside_allowed() -> Iterator[None]:
    """Let files read in this context refer to files outside their own folder."""
    token = _goes_outside.set(True)
    try:
        yield
    finally:
        _goes_outside.reset(token)


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """The limits of a context, to be applied in another process."""

    memory_bytes: int
    goes_outside: bool

    @classmethod
    def current(cls) -> Self:
        """The limits of this context."""
        return cls(memory_bytes=_memory.get(), goes_outside=_goes_outside.get())

    @contextmanager
    def applied(self) -> Iterator[None]:
        """Apply these limits in this context."""
        outside = outside_allowed() if self.goes_outside else nullcontext()
        with memory_limit(self.memory_bytes), outside:
            yield


def may_read(path: PathLike, *folders: Path) -> bool:
    """Test whether `path`, links resolved, lies in one of the folders, or any path is allowed."""
    if "\0" in str(path):
        return True  # no file can have such a name
    place = Path(path).resolve()
    return _goes_outside.get() or any(place.is_relative_to(one.resolve()) for one in folders)


def check_memory(path: PathLike, num_bytes: float) -> None:
    """Raise `InputError` if the content that `path` declares exceeds the memory limit."""
    if num_bytes > _memory.get():
        raise InputError(
            f"{path}: needs {num_bytes / _GIGABYTE:.3g} GB of memory, but "
            f"{_memory.get() / _GIGABYTE:.3g} GB are allowed; give --max-memory"
        )
