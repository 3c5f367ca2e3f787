"""Rows of numbers in a text."""

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.files.atomic import PathLike

Array = NDArray[np.float64]


def rows_of_numbers(text: str, columns: int, name: PathLike, need: str) -> Array:
    """The rows (N, columns) of a text, without blank lines and comments after ``#``.

    Raises
    ------
    InputError
        For a row without `columns` finite numbers, with its line, the `name` of the text and the
        `need` of a row.
    """
    rows = [
        _numbers(words, columns, f"{name}, line {number}", need)
        for number, line in enumerate(text.splitlines(), start=1)
        if (words := line.partition("#")[0].split())
    ]
    return np.array(rows, np.float64).reshape(-1, columns)


def _numbers(words: list[str], columns: int, place: str, need: str) -> Array:
    try:
        numbers = np.array(words, np.float64)
    except ValueError:
        numbers = np.zeros(0)
    if numbers.shape != (columns,) or not np.isfinite(numbers).all():
        raise InputError(f"{place}: {' '.join(words)!r:.80}, but {need} are needed")
    return numbers
