"""Pairs checked, as they pass, against the metadata of the recording."""

import math
from collections import Counter, deque
from collections.abc import Iterator

from recon.notices import notify
from recon.records import PairSource, StereoPair
from recon.sequences.contradictions.angles import angle_finding
from recon.sequences.contradictions.finding import Finding
from recon.sequences.contradictions.moments import REACH, moment_finding
from recon.sequences.contradictions.motions import pose_finding
from recon.sequences.contradictions.pairs import findings
from recon.sequences.contradictions.steps import Step, step_between
from recon.sequences.frames import DerivedSource
from recon.sequences.odometry.tracking import NUM_CORNERS

SURVEYED = (0, 4, 9)
"""Numbers of the first pairs whose images are checked."""
STEPPED = (1, 5, 9)
"""Numbers of the first pairs whose motion since the previous one is measured."""
TIMED = (2, 5, 9)
"""Numbers of the pairs that are compared with the images just before."""
NUM_LATER = 12
"""Maximum number of pairs checked in the rest of the recording, evenly spaced."""
NUM_LATER_CORNERS = 300
"""Corners tracked there: enough for a motion, whereas the angle between the cameras needs all."""
LASTING_SHARE = 0.25
"""Share of the checked pairs, at least two, that must show what does not hold from the start."""
DECIDED = ("not-simultaneous", "left-right-swapped", "angle-differs")
"""Codes that explain all other findings in the images."""


class CheckedPairs(DerivedSource):
    """The unchanged pairs of a source; contradictions are reported once.

    Findings in most of the first checked pairs, or in a good share of all, are reported.
    """

    def __init__(self, source: PairSource, *, has_given_poses: bool) -> None:
        super().__init__(source)
        self._watch = _Watch(source, has_given_poses=has_given_poses)

    def __iter__(self) -> Iterator[StereoPair]:
        for number, pair in enumerate(self.source):
            # A pass goes on where an earlier one ended.
            if number == self._watch.num_pairs:
                self._watch.look_at(pair)
            yield pair
        self._watch.finish()


class _Watch:
    """Findings in the pairs so far."""

    def __init__(self, source: PairSource, *, has_given_poses: bool) -> None:
        self.num_pairs = 0
        self._is_finished = False
        self._before: deque[StereoPair] = deque(maxlen=REACH)
        self._looked_at: list[list[Finding]] = []
        self._timed: list[list[Finding]] = []
        self._steps: list[Step] = []
        later = _later(len(source))
        self._surveyed = frozenset([*SURVEYED, *later])
        self._has_given_poses = has_given_poses
        self._stepped = frozenset([*STEPPED, *later] if has_given_poses else STEPPED)
        self._said: set[str] = set()
        self._has_measured_angle = False

    def look_at(self, pair: StereoPair) -> None:
        """Check the next pair, if it is one of the selected ones."""
        number = self.num_pairs
        if _is_open(self._looked_at, self._surveyed, number) or number in SURVEYED:
            self._looked_at.append(findings(pair.left, pair.right, rig=pair.rig))
        if _is_open(self._timed, frozenset(TIMED), number):
            found = moment_finding(pair, [*self._before])
            self._timed.append([found] if found else [])
        if number in self._stepped and self._before and "poses-disagree" not in self._said:
            corners = NUM_CORNERS if number in STEPPED else NUM_LATER_CORNERS
            step = step_between(self._before[0], pair, num_corners=corners)
            self._steps += [step] if step is not None else []
        if number == SURVEYED[-1]:
            self._say_images(is_end=False)
        if number >= STEPPED[-1] and number in self._stepped:
            self._say_motion()
        self._before.appendleft(pair)
        self.num_pairs += 1

    def finish(self) -> None:
        """Report what only the whole recording shows; once."""
        if not self._is_finished:
            self._is_finished = True
            self._say_images(is_end=True)
            self._say_motion()

    def _say_images(self, *, is_end: bool) -> None:
        """Report the findings in most of the checked pairs, at the end also those in a share."""
        for pairs in (self._timed, self._looked_at):
            for code in dict.fromkeys(finding.code for pair in pairs for finding in pair):
                if not self._said & {code, *DECIDED} and _holds(code, pairs, is_end=is_end):
                    self._said.add(code)
                    notify(code, next(f.text for pair in pairs for f in pair if f.code == code))

    def _say_motion(self) -> None:
        """Report contradictions of the last steps: poses may go wrong anywhere along the path."""
        # Motions from stereo must be reliable themselves to be compared with poses.
        if self._said or not self._steps:
            return
        del self._steps[: -len(STEPPED)]
        found = None if self._has_measured_angle else angle_finding(self._steps)
        self._has_measured_angle = True
        if found is None and self._has_given_poses:
            found = pose_finding([step for step in self._steps if step.is_posed])
        if found is not None:
            self._said.add(found.code)
            where = "" if self.num_pairs <= STEPPED[-1] + 1 else f" (near {self._steps[0].name})"
            notify(found.code, found.text + where)


def _is_open(pairs: list[list[Finding]], chosen: frozenset[int], number: int) -> bool:
    """True if a pair is to be checked, and findings from it on could still be reported."""
    if number not in chosen:
        return False
    left = sum(other >= number for other in chosen)
    counts = Counter(code for pair in pairs for code in {finding.code for finding in pair})
    most = left + max(counts.values(), default=0)
    return most >= 2 and most > LASTING_SHARE * (left + len(pairs))


def _holds(code: str, pairs: list[list[Finding]], *, is_end: bool) -> bool:
    """True if enough of the checked pairs show a finding of this code."""
    number = sum(any(finding.code == code for finding in pair) for pair in pairs)
    is_lasting = is_end and number >= 2 and number > LASTING_SHARE * len(pairs)
    return 2 * number > len(pairs) or is_lasting


def _later(num_pairs: int) -> range:
    """Numbers of the pairs that are checked after the first ones."""
    begin = SURVEYED[-1] + 1
    every = max(1, math.ceil((num_pairs - begin) / NUM_LATER))
    return range(begin + every - 1, num_pairs, every)
