"""What can go wrong by the user's hand, said in one line."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


class ReconError(Exception):
    """Work that failed for a known reason; the command line prints it as one line."""


class InputError(ReconError, ValueError):
    """Input that cannot be used: the message names it, its value and what is needed."""


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


def check_finite(name: str, array: NDArray[np.floating]) -> None:
    """Raise `InputError` where a number of `array` is NaN or infinite."""
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        value = array.reshape(-1)[bad[0]]
        raise InputError(f"{name} holds {value} at flat index {bad[0]}, but finite is needed")
