"""Images decoded last, kept while a job reads its first pairs several times."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from threading import Lock

from recon.sequences.depth import Pixels

MOST_BYTES = 32 << 20
"""Maximum size of all images kept: the first pairs of a recording, unless they are very large."""


class RecentImages:
    """The images decoded last, by their paths."""

    def __init__(self) -> None:
        self._images: dict[Path, Pixels] = {}
        self._num_bytes = 0
        self._lock = Lock()

    def read(self, path: Path, decode: Callable[[], Pixels]) -> Pixels:
        """The image of a path, decoded if it is not kept."""
        image = self._images.get(path)
        if image is None:
            image = decode()
            with self._lock:
                self._keep(path, image)
        return image

    def _keep(self, path: Path, image: Pixels) -> None:
        """Keep an image instead of the oldest ones."""
        if path in self._images:
            return
        self._images[path] = image
        self._num_bytes += image.nbytes
        while self._num_bytes > MOST_BYTES:
            self._num_bytes -= self._images.pop(next(iter(self._images))).nbytes


_recent: ContextVar[RecentImages | None] = ContextVar("recent", default=None)


@contextmanager
def recent_images() -> Iterator[None]:
    """Keep the images decoded last inside the block, in which their files do not change."""
    token = _recent.set(RecentImages())
    try:
        yield
    finally:
        _recent.reset(token)


def recent_image(path: Path, decode: Callable[[], Pixels]) -> Pixels:
    """The image of a path, which is decoded unless a block keeps it."""
    recent = _recent.get()
    return decode() if recent is None else recent.read(path, decode)
