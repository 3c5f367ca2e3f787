"""Names of columns as a format can store them."""

import re
from collections.abc import Callable

from recon.exports.columns import Columns
from recon.exports.numbers import drop_columns

# What separates words, quotes them or begins a comment in headers of text.
_SEPARATING = re.compile(r"[\s\x00-\x1f\x7f,;#\"']+")


def as_words(columns: Columns, place: object) -> Columns:
    """The columns under names of one word each, as headers of text need them."""
    return spelled(columns, lambda name: _SEPARATING.sub("_", name), place)


def spelled(columns: Columns, spelling: Callable[[str], str], place: object) -> Columns:
    """The columns under names in the spelling of a format.

    A notice names those that are left out: their spelling is empty, or the name of another column.
    """
    found: Columns = {}
    left_out = []
    for name, values in columns.items():
        spelt = spelling(name)
        if not spelt or spelt in found or (spelt != name and spelt in columns):
            left_out.append(name)
        else:
            found[spelt] = values
    drop_columns(left_out, place)
    return found


def decoded(header: bytes) -> str:
    """The text of a header: UTF-8, else the 8 bits of older programs."""
    try:
        return header.decode()
    except UnicodeDecodeError:
        return header.decode("latin-1")
