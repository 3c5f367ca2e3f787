"""Storage of a partitioned map: a local folder, or any store that fsspec supports."""

from pathlib import Path
from typing import Any, Protocol

from recon.errors import InputError, check_path
from recon.files import PathLike, atomic_path, check_regular
from recon.libraries import load_extra

MANIFEST = "_partitions.json"
"""Readers of Parquet folders ignore names with this prefix."""
Place = PathLike
"""A path, or a URL such as s3://bucket/map.parquet."""


class Store(Protocol):
    """Files of one folder, each written atomically."""

    def names(self) -> list[str]:
        """Names of the existing files."""
        ...

    def read(self, name: str) -> bytes:
        """The content of a file."""
        ...

    def write(self, name: str, content: bytes) -> None:
        """Write a file, replacing an existing one."""
        ...

    def remove(self, name: str) -> None:
        """Remove a file if it exists."""
        ...


class Folder:
    """A local folder."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def names(self) -> list[str]:
        """Names of the existing files."""
        return [one.name for one in self.path.iterdir()] if self.path.is_dir() else []

    def read(self, name: str) -> bytes:
        """The content of a file."""
        check_regular(self.path / name)
        return (self.path / name).read_bytes()

    def write(self, name: str, content: bytes) -> None:
        """Write a file, replacing an existing one."""
        self.path.mkdir(exist_ok=True)
        with atomic_path(self.path / name) as part:
            part.write_bytes(content)

    def remove(self, name: str) -> None:
        """Remove a file if it exists."""
        (self.path / name).unlink(missing_ok=True)


class Remote:
    """A folder of a store that fsspec supports; object stores write files atomically."""

    def __init__(self, url: str) -> None:
        fsspec: Any = load_extra("fsspec", "tables")
        try:
            self._files, self._root = fsspec.core.url_to_fs(url)
        except (ValueError, ImportError) as error:
            raise InputError(f"{url}: {error}") from error

    def names(self) -> list[str]:
        """Names of the existing files."""
        if not self._files.isdir(self._root):
            return []
        return [str(one).rpartition("/")[2] for one in self._files.ls(self._root, detail=False)]

    def read(self, name: str) -> bytes:
        """The content of a file."""
        content: bytes = self._files.cat_file(f"{self._root}/{name}")
        return content

    def write(self, name: str, content: bytes) -> None:
        """Write a file, replacing an existing one."""
        self._files.makedirs(self._root, exist_ok=True)
        self._files.pipe_file(f"{self._root}/{name}", content)

    def remove(self, name: str) -> None:
        """Remove a file if it exists."""
        if name in self.names():
            self._files.rm_file(f"{self._root}/{name}")


def is_partitioned(place: Place) -> bool:
    """True for a folder that contains a partitioned map, and for every URL."""
    return is_url(place) or (Path(place) / MANIFEST).is_file()


def is_url(place: Place) -> bool:
    """True if fsspec is needed to open it."""
    return isinstance(place, str) and "://" in place


def store_of(place: Place) -> Store:
    """The store for a path or URL."""
    check_path(place)
    return Remote(str(place)) if is_url(place) else Folder(Path(place))
