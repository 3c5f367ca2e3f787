"""Arguments of a kind of job besides its inputs and settings, by name and type."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from recon.errors import InputError, nearest

Argument = Callable[[Any], Any]
"""Converts a value for the kind; the ValueError states what is needed instead."""


def path(value: Any) -> Path:
    """An input file or folder."""
    if not isinstance(value, str | Path):
        raise ValueError("a path")
    return Path(value)


def text(value: Any) -> str:
    """A text, which may be empty."""
    if not isinstance(value, str | Path):
        raise ValueError("text")
    return str(value)


def word(value: Any) -> str:
    """A text that is not empty."""
    if not text(value):
        raise ValueError("a word")
    return text(value)


def texts(value: Any) -> tuple[str, ...]:
    """One word or several."""
    if isinstance(value, str):
        return (value,)
    if not isinstance(value, list | tuple):
        raise ValueError("a list of texts")
    return tuple(text(one) for one in value)


def flag(value: Any) -> bool:
    """Yes or no."""
    if not isinstance(value, bool):
        raise ValueError("true or false")
    return value


def positive(value: Any) -> float:
    """A finite number > 0."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not (is_number and math.isfinite(value) and value > 0):
        raise ValueError("a number > 0")
    return float(value)


def positives(value: Any) -> tuple[float, ...]:
    """One number > 0 or several."""
    several = value if isinstance(value, list | tuple) else (value,)
    return tuple(positive(one) for one in several)


def count(value: Any) -> int:
    """An integer >= 1."""
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise ValueError("a whole number >= 1")
    return value


def span(value: Any) -> tuple[int, int]:
    """Two integers >= 0, the second one larger."""
    is_pair = isinstance(value, list | tuple) and len(value) == 2
    if not is_pair or not all(isinstance(one, int) for one in value):
        raise ValueError("[first, end], two whole numbers,")
    first, end = value
    if not 0 <= first < end:
        raise ValueError("a non-empty span >= 0")
    return first, end


def one_of(*choices: str) -> Argument:
    """One of some words."""

    def choice(value: Any) -> str:
        if value not in choices:
            raise ValueError(f"one of {', '.join(choices)}")
        return str(value)

    return choice


def checked(kind: str, given: Mapping[str, Any], takes: Mapping[str, Argument]) -> dict[str, Any]:
    """The arguments of a job, converted for its kind.

    Raises
    ------
    InputError
        For an unknown name, with the nearest known one, and for a wrong value.
    """
    found = {}
    for name, value in given.items():
        if name not in takes:
            known = f"the nearest is {nearest(name, takes)}" if takes else "it takes none"
            raise InputError(f"argument {name} is unknown to {kind}; {known}")
        try:
            found[name] = takes[name](value)
        except ValueError as error:
            raise InputError(f"{kind}: {name} is {value!r}, but {error} is needed") from error
    return found


def check_distinct(inputs: Iterable[Path]) -> None:
    """Raise `InputError` if a file or folder is given twice, by whatever names."""
    for place, times in Counter(one.resolve() for one in inputs).items():
        if times > 1:
            raise InputError(f"{place} is given {times} times, but must count once")
