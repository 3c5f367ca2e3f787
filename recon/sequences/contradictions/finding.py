"""The result of a check."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One contradiction between images, or between images and their metadata."""

    code: str
    text: str
