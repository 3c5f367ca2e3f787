"""Every reader accepts mutated files or rejects them in one line, never with a traceback."""

import time
from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from tests.fuzzing import fault, mutated, readers, within

NUM_MUTATIONS = 50
"""Mutations per format; `tools/fuzz.py` makes ten thousand."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("sound")


@pytest.fixture(scope="module")
def valid_files(folder):
    return readers(folder)


def test_valid_files_are_read(valid_files, folder):
    for one in valid_files.values():
        path = folder / f"whole{one.name}"
        path.write_bytes(one.content)
        one.read(path)


def test_mutated_files_are_read_or_rejected_in_one_line(valid_files, folder, capfd):
    faults = {}
    for number, (name, one) in enumerate(valid_files.items()):
        for seed in range(round(one.share * NUM_MUTATIONS)):
            content = mutated(one.content, np.random.default_rng([number, seed]))
            wrong = fault(one, content, folder)
            if wrong:
                faults[name, seed] = wrong
        assert capfd.readouterr() == ("", ""), name
    assert faults == {}


def test_fuzzer_finds_a_fault(valid_files, folder):
    weak = replace(valid_files[".ply"], read=lambda path: path.read_bytes().decode("ascii"))
    rngs = [np.random.default_rng(seed) for seed in range(9)]
    found = [fault(weak, mutated(weak.content, rng), folder) for rng in rngs]
    assert any(wrong and wrong.startswith("UnicodeDecodeError") for wrong in found)


def test_fuzzer_finds_a_reader_that_computes_or_waits_too_long():
    with pytest.raises(TimeoutError, match="processor time"), within(0.05, 100.0):
        for _ in count():
            pass
    with pytest.raises(TimeoutError, match="waiting"), within(100.0, 0.05):
        time.sleep(100)
