"""The table of equations refers to existing functions and tests, and covers every equation."""

import importlib
import re
from functools import reduce
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def rows():
    text = (ROOT / "docs" / "equations.md").read_text()
    cells = [line.strip("| \n").split(" | ") for line in text.splitlines() if line.startswith("| ")]
    return [row for row in cells if re.match(r"\d", row[0]) and len(row) == 5]


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[0])
def test_function_and_test_of_an_equation_exist(row):
    module, _, path = row[3].strip("`").partition(":")
    assert callable(reduce(getattr, path.split("."), importlib.import_module(module)))
    file, _, name = row[4].strip("`").partition("::")
    assert re.search(rf"^def {name}\(", (ROOT / file).read_text(), re.M), row[4]


def test_every_numbered_equation_has_a_row():
    text = (ROOT / "docs" / "equations.md").read_text()
    named = set()
    for cell in re.findall(r"^\| (\d[\d, to]*) \|", text, re.M):
        numbers = [int(n) for n in re.findall(r"\d+", cell)]
        named |= set(range(numbers[0], numbers[-1] + 1)) if "to" in cell else set(numbers)
    assert named == set(range(1, 59))
