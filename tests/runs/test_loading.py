"""The first pair of a recording, read while loops are loaded."""

import pytest

from recon.errors import InputError
from recon.notices import collected_notices, notify
from recon.runs.loading import first_pair
from recon.settings import Settings


def test_the_first_pair_is_returned_and_no_other_is_read():
    read = []

    def pairs():
        for name in "ab":
            read.append(name)
            yield name

    assert first_pair(pairs(), Settings()) == "a"
    assert read == ["a"]


def test_what_is_wrong_with_the_first_pair_is_raised_and_noted():
    def pairs():
        notify("frames-skipped", "one is damaged")
        raise InputError("no pair could be read")
        yield

    with (
        collected_notices() as notices,
        pytest.raises(InputError, match="no pair could be read"),
    ):
        first_pair(pairs(), Settings())
    assert [notice.code for notice in notices] == ["frames-skipped"]
