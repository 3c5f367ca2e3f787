"""The place of a partitioned map: a folder of this machine, or of any store that fsspec knows."""

from pathlib import Path
from typing import Any, Protocol

from recon.errors import InputError
from recon.files import PathLike, atomic_path, check_regular
from recon.libraries import load_extra

MANIFEST = "_partitions.json"
"""Readers of folders of Parquet pass over names that begin so."""
Place = PathLike
"""A path, or a URL such as s3://bucket/map.parquet."""


class Store(Protocol):
    """Files of one folder, each of which appears whole or not at all."""

    def names(self) -> list[str]:
        """Names of the files that are there."""
        ...

    def read(self, name: str) -> bytes:
        """The content of a file."""
        ...

    def write(self, name: str, content: bytes) -> None:
        """Write a file, in place of one that is there."""
        ...

    def remove(self, name: str) -> None:
        """Remove a file where it is there."""
        ...


class Folder:
    """A folder of this machine."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def names(self) -> list[str]:
        """Names of the files that are there."""
        return [one.name for one in self.path.iterdir()] if self.path.is_dir() else []

    def read(self, name: str) -> bytes:
        """The content of a file."""
        check_regular(self.path / name)
        return (self.path / name).read_bytes()

    def write(self, name: str, content: bytes) -> None:
        """Write a file, in place of one that is there."""
        self.path.mkdir(exist_ok=True)
        with atomic_path(self.path / name) as part:
            part.write_bytes(content)

    def remove(self, name: str) -> None:
        """Remove a file where it is there."""
        (self.path / name).unlink(missing_ok=True)


class Remote:
    """A folder of a store that fsspec knows; object stores put a file there whole."""

    def __init__(self, url: str) -> None:
        fsspec: Any = load_extra("fsspec", "tables")
        try:
            self._files, self._root = fsspec.core.url_to_fs(url)
        except (ValueError, ImportError) as error:
            raise InputError(f"{url}: {error}") from error

    def names(self) -> list[str]:
        """Names of the files that are there."""
        if not self._files.isdir(self._root):
            return []
        return [str(one).rpartition("/")[2] for one in self._files.ls(self._root, detail=False)]

    def read(self, name: str) -> bytes:
        """The content of a file."""
        content: bytes = self._files.cat_file(f"{self._root}/{name}")
        return content

    def write(self, name: str, content: bytes) -> None:
        """Write a file, in place of one that is there."""
        self._files.makedirs(self._root, exist_ok=True)
        self._files.pipe_file(f"{self._root}/{name}", content)

    def remove(self, name: str) -> None:
        """Remove a file where it is there."""
        if name in self.names():
            self._files.rm_file(f"{self._root}/{name}")


def is_partitioned(place: Place) -> bool:
    """True for a folder that holds a partitioned map, and for every URL."""
    return is_url(place) or (Path(place) / MANIFEST).is_file()


def is_url(place: Place) -> bool:
    """True for what fsspec has to open."""
    return isinstance(place, str) and "://" in place


def store_of(place: Place) -> Store:
    """The store at a place."""
    return Remote(str(place)) if is_url(place) else Folder(Path(place))
