"""Pairs of left and right images, by their names."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from recon.errors import InputError
from recon.sequences.images import ENDINGS


@dataclass(frozen=True, slots=True, kw_only=True)
class Listed:
    """One entry of a recording, with at least one of the two images."""

    name: str
    left: Path | None
    right: Path | None


def list_pairs(left_dir: Path, right_dir: Path) -> list[Listed]:
    """The images of two folders, paired by name and sorted; a missing partner is None.

    Names are equal on both sides, or have the same last number (left07.jpg, right07.jpg), or are
    paired in sorted order if equally many. Both sides may be in one folder, if the names contain
    "left" and "right".

    Raises
    ------
    InputError
        If a folder is missing or empty, or if the pairing is ambiguous.
    """
    lefts, rights = _images(left_dir), _images(right_dir)
    if lefts == rights:
        lefts, rights = _of_side(left_dir, "left"), _of_side(left_dir, "right")
    for key in (_stem, _last_number):
        left, right = ({key(path): path for path in paths} for paths in (lefts, rights))
        unique = len(left) == len(lefts) and len(right) == len(rights)
        if unique and left.keys() & right.keys():
            names = sorted(left.keys() | right.keys(), key=natural)
            return [Listed(name=n, left=left.get(n), right=right.get(n)) for n in names]
    if len(lefts) != len(rights):
        raise InputError(
            f"{left_dir} has {len(lefts)} images and {right_dir} {len(rights)} with other "
            "names, but the names must identify the pairs"
        )
    return [
        Listed(name=left.stem, left=left, right=right)
        for left, right in zip(lefts, rights, strict=True)
    ]


def gaps(listed: Sequence[Listed]) -> list[str]:
    """Names missing on both sides, if names are numbers with a fixed step.

    Times in nanoseconds jitter and are not a count: most steps must equal the smallest one.
    """
    if len(listed) < 3 or not all(entry.name.isdigit() for entry in listed):
        return []
    numbers = [int(entry.name) for entry in listed]
    steps = [later - sooner for sooner, later in pairwise(numbers)]
    step = min(steps)
    is_count = step > 0 and not any(size % step for size in steps)
    if not is_count or steps.count(step) * 2 < len(steps) or sum(steps) > 2 * step * len(numbers):
        return []
    missing = sorted({*range(numbers[0], numbers[-1], step)} - {*numbers})
    return [str(number).zfill(len(listed[0].name)) for number in missing]


def natural(name: str) -> tuple[tuple[int, int, str], ...]:
    """A sorting key that places frame10 after frame9."""
    parts = re.findall(r"\d+|\D+", name)
    return tuple((0, int(p), "") if p.isdigit() else (1, 0, p) for p in parts)


def _images(folder: Path) -> list[Path]:
    if not folder.is_dir():
        raise InputError(f"{folder} is not a folder, but one of images is needed")
    found = [p for p in folder.iterdir() if p.suffix.lower() in ENDINGS and p.name[0] != "."]
    if not found:
        raise InputError(f"{folder} contains no images ({', '.join(sorted(ENDINGS))})")
    return sorted(found, key=lambda path: natural(path.stem))


def _of_side(folder: Path, side: str) -> list[Path]:
    found = [path for path in _images(folder) if side in path.stem.lower()]
    if not found:
        raise InputError(f"{folder} is given for both sides, but no name in it contains {side}")
    return found


def _stem(path: Path) -> str:
    return path.stem


def _last_number(path: Path) -> str:
    numbers = re.findall(r"\d+", path.stem)
    return numbers[-1] if numbers else path.stem
