"""Notices: contradictory measurements, reported once with a code (`warnings` in JSON)."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Notice:
    """One finding."""

    code: str
    """Stable name of its kind, such as `rows-differ`."""
    text: str
    """One human-readable line."""

    def as_json(self) -> dict[str, str]:
        """The notice as an entry of `warnings`."""
        return {"code": self.code, "text": self.text}


_collected: ContextVar[list[Notice] | None] = ContextVar("recon_notices", default=None)


def notify(code: str, text: str) -> None:
    """Log a finding as a warning, and add it to the collected notices."""
    notice = Notice(code, text)
    notices = _collected.get()
    if notices is not None:
        if notice in notices:
            return
        notices.append(notice)
    log.warning("%s: %s", code, text)


@contextmanager
def collected_notices() -> Iterator[list[Notice]]:
    """Collect the notices of this context, in order and without duplicates."""
    notices: list[Notice] = []
    token = _collected.set(notices)
    try:
        yield notices
    finally:
        _collected.reset(token)
