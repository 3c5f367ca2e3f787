"""What the pages say is what the code does."""

import ast
import re
from pathlib import Path

from recon.settings import Settings, with_preset
from recon.settings.files import to_tree

DOCS = Path(__file__).parents[1] / "docs"


def flat(settings):
    tree = to_tree(settings)
    return {
        f"{stage}.{name}": value for stage, table in tree.items() for name, value in table.items()
    }


def value(text):
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text


def rows():
    text = (DOCS / "thesis.md").read_text()
    return {
        name: (value(thesis), value(own))
        for name, thesis, own in re.findall(r"^\| `([\w.]+)` \| (.+?) \| (.+?) \|", text, re.M)
    }


def test_the_table_of_parameters_is_the_preset():
    own, thesis = flat(Settings()), flat(with_preset(Settings(), "thesis"))
    table = rows()
    assert {name: (thesis[name], own[name]) for name in table} == table


def test_no_difference_is_left_out():
    own, thesis = flat(Settings()), flat(with_preset(Settings(), "thesis"))
    assert {name for name in own if own[name] != thesis[name]} <= set(rows())
