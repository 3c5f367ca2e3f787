"""Checks of a recording end where nothing can be reported any more, and lose no report by it."""

from types import SimpleNamespace

import numpy as np
import pytest

from recon.notices import collected_notices
from recon.sequences.contradictions import checked
from recon.sequences.contradictions.checked import LASTING_SHARE, SURVEYED, CheckedPairs
from recon.sequences.contradictions.finding import Finding

CODES = ("rows-differ", "brightness-differs")


class Drive(list):
    """Pairs that hold the codes that a check of their images finds."""

    disparity_range = None

    @classmethod
    def of(cls, num_pairs, **numbers):
        """A drive whose pairs with the numbers of a code show it."""
        return cls(
            SimpleNamespace(
                left=number, right=[c for c in numbers if number in numbers[c]], rig=None
            )
            for number in range(num_pairs)
        )


@pytest.fixture
def passed(monkeypatch):
    """Pass over a drive; return the numbers of the checked pairs, and the reported codes."""
    looked_at = []

    def findings(left, right, *, rig):
        looked_at.append(left)
        return [Finding(code=code, text=code) for code in right]

    monkeypatch.setattr(checked, "findings", findings)
    monkeypatch.setattr(checked, "moment_finding", lambda pair, before: None)
    monkeypatch.setattr(checked, "step_between", lambda before, pair, num_corners: None)

    def go(drive):
        looked_at.clear()
        with collected_notices() as notices:
            assert [*CheckedPairs(drive, has_given_poses=False)] == drive
        return [*looked_at], {notice.code for notice in notices}

    return go


def chosen(num_pairs):
    """Numbers of the pairs that are checked unless checks end early."""
    numbers = {*SURVEYED, *checked._later(num_pairs)}
    return sorted(number for number in numbers if number < num_pairs)


def test_checks_of_a_correct_recording_end_with_too_few_pairs_left_to_report_anything(passed):
    numbers = chosen(100)
    needed = int(LASTING_SHARE * len(numbers)) + 1
    assert passed(Drive.of(100)) == (numbers[: 1 - needed], set())


def test_what_begins_as_late_as_can_be_reported_is_reported(passed):
    numbers = chosen(100)
    needed = int(LASTING_SHARE * len(numbers)) + 1
    late = Drive.of(100, rows=numbers[-needed:])
    assert passed(late) == (numbers, {"rows"})
    assert passed(Drive.of(100, rows=numbers[1 - needed :]))[1] == set()


def test_an_early_finding_keeps_the_checks_going(passed):
    numbers = chosen(100)
    found = [numbers[0], *numbers[-3:]]
    assert passed(Drive.of(100, rows=found)) == (numbers, {"rows"})


@pytest.mark.parametrize("seed", range(20))
def test_reports_are_those_of_all_checks(passed, monkeypatch, seed):
    rng = np.random.default_rng(seed)
    num_pairs = int(rng.integers(1, 120))
    shares = dict(zip(CODES, rng.uniform(0.0, 0.5, len(CODES)), strict=True))
    drive = Drive.of(
        num_pairs,
        **{code: np.flatnonzero(rng.random(num_pairs) < share) for code, share in shares.items()},
    )
    early, reported = passed(drive)
    monkeypatch.setattr(checked, "_is_open", lambda pairs, numbers, number: number in numbers)
    everywhere, expected = passed(drive)
    assert reported == expected
    assert everywhere == chosen(num_pairs)
    later = [number for number in everywhere if number not in SURVEYED]
    assert [number for number in early if number not in SURVEYED] == later[: len(early) - 3]
