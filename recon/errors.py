"""Errors that a user can fix, reported in one line."""

import difflib
import os
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray


class ReconError(Exception):
    """Work that failed for a known reason; the command line prints it as one line."""


class InputError(ReconError, ValueError):
    """Unusable input: the message names it, its value and what is needed."""


class MissingLibraryError(ReconError, ImportError):
    """A library that is not installed or not loadable; the message says how to get it."""


def check_shape(name: str, array: NDArray[np.generic], shape: Sequence[int | None]) -> None:
    """Raise unless `array` has `shape`, where None stands for any length.

    Raises
    ------
    InputError
        "disparity_px has shape (4,), but (3,) is needed".
    """
    if not isinstance(array, np.ndarray):
        raise InputError(f"{name} is a {type(array).__name__}, but an array is needed")
    fits = array.ndim == len(shape) and all(
        need is None or need == have for need, have in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("N" if need is None else str(need) for need in shape)
        wanted += "," if len(shape) == 1 else ""
        raise InputError(f"{name} has shape {array.shape}, but ({wanted}) is needed")


def as_numbers(name: str, value: object) -> NDArray[np.float64]:
    """`value` as an array of float64.

    Raises
    ------
    InputError
        If it does not consist of numbers.
    """
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is {value!r}, but numbers are needed") from error


def check_number(name: str, value: object, *, low: float = -np.inf, above: float = -np.inf) -> None:
    """Raise unless `value` is a finite number, at least `low` and more than `above`.

    Raises
    ------
    InputError
        "cell_size is 'x', but a number > 0 is needed".
    """
    is_number = isinstance(value, int | float | np.integer | np.floating)
    if is_number and not isinstance(value, bool):
        number = float(value)  # type: ignore[arg-type]
        if np.isfinite(number) and number >= low and number > above:
            return
    need = "a finite number"
    if low > -np.inf:
        need = f"a number >= {low:g}"
    if above > -np.inf:
        need = f"a number > {above:g}"
    raise InputError(f"{name} is {value!r}, but {need} is needed")


def check_type(name: str, value: object, wanted: type, *others: type) -> None:
    """Raise `InputError` unless `value` is of one of the types."""
    if not isinstance(value, (wanted, *others)):
        words = " or ".join(one.__name__ for one in (wanted, *others))
        raise InputError(f"{name} is of type {type(value).__name__}, but {words} is needed")


def check_path(value: object) -> None:
    """Raise `InputError` unless `value` is a path."""
    if not isinstance(value, str | os.PathLike):
        raise InputError(f"path is {value!r}, but a path is needed")


def check_finite(name: str, array: NDArray[np.floating]) -> None:
    """Raise `InputError` if a number of `array` is NaN or infinite."""
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        value = array.reshape(-1)[bad[0]]
        raise InputError(f"{name} holds {value} at flat index {bad[0]}, but must be finite")


def nearest(name: str, known: Iterable[str]) -> str:
    """The known name that begins with `name`, else the most similar one."""
    names = list(known)
    begun = [one for one in names if one.startswith(name)]
    return min(begun, key=len) if begun else difflib.get_close_matches(name, names, 1, 0.0)[0]


def one_line(error: BaseException) -> str:
    """The text of an error, cut to one line of moderate length; its type if it has none."""
    return " ".join(str(error).split())[:200] or type(error).__name__


def unknown(said: str, name: str, known: Iterable[str]) -> str:
    """The message about an unknown `name`, which `said` introduces."""
    return f"{said} is unknown; the nearest known name is {nearest(name, known)}"
